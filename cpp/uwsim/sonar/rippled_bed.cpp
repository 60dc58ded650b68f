#include "uwsim/sonar/rippled_bed.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace uwsim {

std::array<double, 2> RippledBed::facets(const BedPatch& patch) const {
  Eigen::Vector3d up = patch.normal_world.normalized();
  if (up.z() < 0) up = -up;
  const double flat = std::clamp(-up.dot(patch.direction_world), 0.0, 1.0);
  if (up.z() < SandRipples::steepest(patch.point_world_m)) return {flat, flat};
  const SandRipples::Wave wave = ripples_.at(patch.point_world_m);
  const Eigen::Vector2d &across = ripples_.across(), ahead = patch.direction_world.head<2>();
  const double level = ahead.norm(), share = level > 0 ? across.dot(ahead) / level : 1;
  const double width_m =
      std::hypot(patch.along_m * share, patch.across_m * std::sqrt(std::max(0.0, 1 - share * share)));
  const double phases = 2 * std::numbers::pi * width_m / double{kRipple_m};
  const double followed = std::exp(-phases * phases / 24);  // of a wave's amplitude, by the variance of a uniform patch
  const double slope = wave.amplitude * followed * std::cos(wave.phase_rad);
  const double spread = wave.amplitude * std::sqrt(0.5 * (1 - followed * followed));
  const auto facing = [&](double steepness) {
    const Eigen::Vector3d normal = up - Eigen::Vector3d(steepness * across.x(), steepness * across.y(), 0);
    return std::clamp(-normal.dot(patch.direction_world) / normal.norm(), 0.0, 1.0);
  };
  return {facing(slope - spread), facing(slope + spread)};
}

}  // namespace uwsim
