#pragma once

#include <Eigen/Core>

namespace uwsim {

/// The length and the steepest slope of ripples of sand, as cameras show them (camera/material.cpp). Ripples that waves
/// make are some 0.1 to 1 m long, and no steeper than sand rests. These values are assumed.
inline constexpr float kRipple_m = .28f, kRippleTilt = .45f;

/// Ripples of sand, which the terrain's heights do not have: slopes as a function of place. They are those that cameras
/// shade (camera/kernels/materials.h): sinusoidal along a horizontal direction, in patches of 1.4 m, which vary their
/// height and bend their crests.
class SandRipples {
 public:
  /// across_rad: of the horizontal direction across the crests, from x to y.
  explicit SandRipples(double across_rad);

  /// A slope amplitude cos(phase_rad) along `across`.
  struct Wave {
    double amplitude, phase_rad;
  };
  Wave at(const Eigen::Vector3d& point_world_m) const;
  /// The height of a unit normal's z below which the bed is too steep for sand, so that it has none.
  static double steepest(const Eigen::Vector3d& point_world_m);
  const Eigen::Vector2d& across() const { return across_; }

 private:
  Eigen::Vector2d across_;
};

}  // namespace uwsim
