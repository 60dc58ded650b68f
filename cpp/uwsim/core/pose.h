#pragma once

#include <Eigen/Geometry>

namespace uwsim {

/// A rigid transform. Transforms are chained by multiplication: `world_from_sonar = world_from_body * body_from_sonar`.
/// The world frame is ENU, with z up and the mean water surface at z = 0; body axes are x forward, y left, z up (REP
/// 103).
struct Pose {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();

  Eigen::Vector3d point(const Eigen::Vector3d& local) const { return position_m + orientation * local; }
  Eigen::Vector3d direction(const Eigen::Vector3d& local) const { return orientation * local; }
  Eigen::Matrix3d rotation() const { return orientation.toRotationMatrix(); }
  Eigen::Matrix4d matrix() const;
  Pose inverse() const;
};

Pose operator*(const Pose& a_from_b, const Pose& b_from_c);

}  // namespace uwsim
