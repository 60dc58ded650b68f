#pragma once

#include <vector>

#include "uwsim/camera/kernels/view.h"

namespace uwsim {

/// Depths of the levels are kFirstCausticLevel_m 2^k.
inline constexpr double kFirstCausticLevel_m = 0.5;
static_assert(static_cast<float>(kFirstCausticLevel_m) == camera::kFirstCausticLevel_m);

/// Caustics under one tile of ripples, [cell y][cell x][level]: vertical light over its mean on a level plane, so that
/// its mean is 1. Light that meets the surface at x reaches depth d at x + d (1 - 1 / n) grad h (small slopes). Each
/// level sums a lattice of such rays where they arrive, so that folds, where several sheets of light overlap, come out
/// bright. Blurred by the sun's angular size. `slopes`: Ripples::Snapshot's.
std::vector<float> caustics_under(const std::vector<float>& slopes, double refractive_index, int threads);

}  // namespace uwsim
