#pragma once

#include <compare>
#include <vector>

#include "uwsim/camera/kernels/view.h"

namespace uwsim {

/// The depths of the levels are kFirstCausticLevel_m 2^k.
inline constexpr double kFirstCausticLevel_m = 0.5;
static_assert(static_cast<float>(kFirstCausticLevel_m) == camera::kFirstCausticLevel_m);

/// The water that spreads focused light: its scattering [1/m], and the mean angle of that.
struct FocusWater {
  double refractive_index = 1.333, scattering_per_m = 0, scattering_rad = 0;
  auto operator<=>(const FocusWater&) const = default;
};

/// The share of a pattern of light at wave number k [rad/m] that is left after `path_m` of water: exp(-b d (1 - (1 -
/// exp(-x)) / x)), x = t k d, with mean scattering angle t (Wells 1973, as in forward_scatter.h: a pattern spreads in
/// water as a picture does). A share exp(-b d) stays sharp.
double pattern_left(const FocusWater& water, double wave_number_per_m, double path_m);

/// Returns the caustics under one tile of ripples, [cell y][cell x][level]: the light on a level plane relative to its
/// mean, so that the mean is 1. Light that meets the surface at x reaches depth d at x + d (1 - 1 / n) grad h (small
/// slopes). Each level sums the arrivals of a lattice of such rays, so that folds, where several sheets of light
/// overlap, are bright. Each is spread by the sun's disc, by waves shorter than the tile's, whose slopes have a
/// standard deviation of `short_slope` along each axis, and by the water (`pattern_left`). `slopes`: from
/// Ripples::Snapshot. Levels before `first_level` may be left 0.
std::vector<float> caustics_under(const std::vector<float>& slopes, double short_slope, const FocusWater& water,
                                  int first_level, int threads);

}  // namespace uwsim
