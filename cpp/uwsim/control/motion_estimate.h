#pragma once

#include <Eigen/Core>
#include <cmath>
#include <numbers>

#include "uwsim/core/body_state.h"

namespace uwsim {

/// A controller's information about its vehicle: pose and velocity over ground, true or estimated.
struct MotionEstimate {
  Eigen::Matrix3d world_from_body = Eigen::Matrix3d::Identity();
  Eigen::Vector3d position_world_m = Eigen::Vector3d::Zero();
  Vector6d velocity_body = Vector6d::Zero();  ///< [m/s, rad/s]

  /// Heading of the body's x axis from the world's x axis, counter-clockwise, in [-pi, pi].
  double yaw_rad() const { return std::atan2(world_from_body(1, 0), world_from_body(0, 0)); }
};

/// Wraps an angle to [-pi, pi).
inline double wrap_angle(double angle_rad) {
  const double turn = 2 * std::numbers::pi;
  const double rest = std::fmod(angle_rad + std::numbers::pi, turn);
  return (rest < 0 ? rest + turn : rest) - std::numbers::pi;
}

}  // namespace uwsim
