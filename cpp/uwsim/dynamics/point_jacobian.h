#pragma once

#include <Eigen/Core>

#include "uwsim/core/pose.h"

namespace uwsim {

/// Velocity along the world axes of a point that moves with a body, per nu along the body's axes.
inline Eigen::Matrix<double, 3, 6> point_jacobian(const Pose& pose, const Eigen::Vector3d& point_body_m) {
  const Eigen::Matrix3d rotation = pose.rotation();
  Eigen::Matrix3d across;
  across << 0, -point_body_m.z(), point_body_m.y(), point_body_m.z(), 0, -point_body_m.x(), -point_body_m.y(),
      point_body_m.x(), 0;
  Eigen::Matrix<double, 3, 6> j;
  j << rotation, -rotation * across;
  return j;
}

}  // namespace uwsim
