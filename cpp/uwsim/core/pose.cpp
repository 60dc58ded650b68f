#include "uwsim/core/pose.h"

namespace uwsim {

Eigen::Matrix4d Pose::matrix() const {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() = rotation();
  m.topRightCorner<3, 1>() = position_m;
  return m;
}

Pose Pose::inverse() const {
  const Eigen::Quaterniond back = orientation.conjugate();
  return {-(back * position_m), back};
}

Pose operator*(const Pose& a_from_b, const Pose& b_from_c) {
  return {a_from_b.point(b_from_c.position_m), (a_from_b.orientation * b_from_c.orientation).normalized()};
}

}  // namespace uwsim
