#pragma once

#include <Eigen/Core>
#include <cstring>

#include "uwsim/core/pose.h"

namespace uwsim {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// (linear, angular). Pairs are made in registers: a processor waits where a pair is loaded of which two halves, such
/// as the last number of one vector and the first of the next, were stored separately.
inline Vector6d joined(const Eigen::Vector3d& linear, const Eigen::Vector3d& angular) {
  using Pair [[gnu::vector_size(16)]] = double;
  const Pair pairs[] = {{linear.x(), linear.y()}, {linear.z(), angular.x()}, {angular.y(), angular.z()}};
  Vector6d both;
  std::memcpy(both.data(), pairs, sizeof pairs);
  return both;
}

/// Pose and velocity of a body. Six-vectors are (linear, angular) in the body frame at the body's origin: Fossen's nu =
/// (u, v, w, p, q, r) with REP 103 axes (x forward, y left, z up).
struct BodyState {
  Pose world_from_body;
  Vector6d velocity_body = Vector6d::Zero();  ///< [m/s, rad/s]

  Eigen::Vector3d linear_body_m_s() const { return velocity_body.head<3>(); }
  Eigen::Vector3d angular_body_rad_s() const { return velocity_body.tail<3>(); }
};

}  // namespace uwsim
