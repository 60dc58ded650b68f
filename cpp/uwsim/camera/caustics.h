#pragma once

#include <vector>

#include "uwsim/camera/kernels/view.h"

namespace uwsim {

/// The depths of the levels are kFirstCausticLevel_m 2^k.
inline constexpr double kFirstCausticLevel_m = 0.5;
static_assert(static_cast<float>(kFirstCausticLevel_m) == camera::kFirstCausticLevel_m);

/// Returns the caustics under one tile of ripples, [cell y][cell x][level]: the light on a level plane relative to its
/// mean, so that the mean is 1. Light that meets the surface at x reaches depth d at x + d (1 - 1 / n) grad h (small
/// slopes). Each level sums the arrivals of a lattice of such rays, so that folds, where several sheets of light
/// overlap, are bright. Blurred by the sun's angular size. `slopes`: from Ripples::Snapshot. Levels before
/// `first_level` are left 0.
std::vector<float> caustics_under(const std::vector<float>& slopes, double refractive_index, int first_level,
                                  int threads);

}  // namespace uwsim
