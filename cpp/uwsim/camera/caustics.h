#pragma once

#include <Eigen/Core>
#include <cmath>
#include <numbers>
#include <vector>

#include "uwsim/camera/kernels/view.h"

namespace uwsim {

/// The levels lie at kFirstCausticLevel_m 2^k along the beam.
inline constexpr double kFirstCausticLevel_m = 0.5;
static_assert(static_cast<float>(kFirstCausticLevel_m) == camera::kFirstCausticLevel_m);

/// The sun over level water, whose waves focus its beam.
struct FocusedSun {
  double refractive_index = 1.333;
  Eigen::Vector2d to_sun_in_air{0, 0};  ///< the level part of the unit vector towards it
  double scattering_per_m = 0;          ///< by particles
  bool operator==(const FocusedSun&) const = default;

  double cosine_in_air() const { return std::sqrt(1 - to_sun_in_air.squaredNorm()); }
  double cosine_in_water() const {
    return std::sqrt(1 - to_sun_in_air.squaredNorm() / (refractive_index * refractive_index));
  }
  /// The beam's level way towards the sun per metre of depth.
  Eigen::Vector2d slant() const { return to_sun_in_air / (refractive_index * cosine_in_water()); }
  /// The turn of the beam per slope of the surface, by Snell's law: 1 - 1 / n under a sun overhead.
  double bend() const { return cosine_in_water() - cosine_in_air() / refractive_index; }
};

/// How far light moves on a level plane per metre of its path if its direction's level part changes by this: more in
/// the sun's plane than across it. On waves of light, the transpose, which is the same.
inline Eigen::Vector2d moved_on_level(const Eigen::Vector2d& slant, const Eigen::Vector2d& change) {
  return change + change.dot(slant) * slant;
}

/// The light that is scattered by less than this still counts as the sun's beam; the rest is even.
inline constexpr double kBeamEdge_rad = 15 * std::numbers::pi / 180;

/// The share of a pattern of the beam's light that is left after a path d [m] of water, by its wave number k [rad/m]
/// across the beam: exp(-b d (w - m)), where w is `scattered_within` of the beam's edge and m `kept_when_scattered` of
/// k d. A share exp(-b d w) stays sharp.
double pattern_left(double scattering_per_m, double wave_number_per_m, double path_m);

/// Returns the caustics under one tile of ripples, [cell y][cell x][level]: the light on a level plane relative to its
/// mean, so that the mean is 1. Each level sums the arrivals of a lattice of rays that the slopes refract (Snell), so
/// that folds, where several sheets of light overlap, are bright. Each is spread by the sun's disc as it is seen from
/// below, by waves shorter than the tile's, whose slopes have a standard deviation of `short_slope` along each axis,
/// and by the water (`pattern_left`). `slopes`: from Ripples::Snapshot. Levels before `first_level` may be left 0.
std::vector<float> caustics_under(const std::vector<float>& slopes, double short_slope, const FocusedSun& sun,
                                  int first_level, int threads);

}  // namespace uwsim
