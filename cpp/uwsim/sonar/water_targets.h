#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

namespace uwsim {

/// A group of point targets in the water: a school of fish, which does not move, or the bubbles of a seep, which rise.
/// Each target scatters according to its target strength. Targets do not shadow each other, and multiple scattering is
/// not modelled.
struct WaterTargets {
  std::string name;                                      ///< keys the random positions
  bool rises = false;                                    ///< a seep; otherwise a school
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< the middle of a school; the source of a seep's bubbles
  /// A school fills an ellipsoid with these diameters. A seep's plume is an upright cone with its tip at the source: z
  /// is its height, x and y its diameters at the top.
  Eigen::Vector3d size_m = Eigen::Vector3d::Ones();
  int count = 100;
  double target_strength_db = -38;  ///< of each target, re 1 m^2
  double rise_m_s = 0;              ///< of bubbles; a bubble that reaches the plume's top starts again at the source

  /// Throws InvalidValue naming the field below `path`.
  void check(const std::string& path) const;
};

/// The positions of a group's targets over time, drawn once: a function of seed, name and time.
class MovingTargets {
 public:
  MovingTargets(const WaterTargets& group, std::uint64_t seed);

  /// The positions, (3, count), world frame. Those above the water's surface contain no target.
  Eigen::Matrix3Xd at(double time_s) const;
  double cross_section_m2() const { return cross_section_m2_; }

 private:
  WaterTargets group_;
  Eigen::Matrix3Xd unit_;  // in the unit ball; for a seep, in the unit disc, and by height in [0, 1)
  double cross_section_m2_;
};

}  // namespace uwsim
