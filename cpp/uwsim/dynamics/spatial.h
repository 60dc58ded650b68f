#pragma once

#include "uwsim/core/body_state.h"

// Spatial vectors (Featherstone 2008, "Rigid Body Dynamics Algorithms", ch. 2) in this project's order: a motion is
// (linear, angular), a force is (force, moment), both at a body's origin along its axes.
namespace uwsim {

inline Eigen::Matrix3d cross_matrix_of(const Eigen::Vector3d& v) {
  Eigen::Matrix3d s;
  s << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return s;
}

/// v x m, the rate of a motion that is constant along axes which move at v (Featherstone 2.31).
inline Vector6d cross_motion(const Vector6d& v, const Vector6d& motion) {
  const Eigen::Vector3d linear = v.head<3>(), angular = v.tail<3>();
  Vector6d rate;
  rate << angular.cross(motion.head<3>()) + linear.cross(motion.tail<3>()), angular.cross(motion.tail<3>());
  return rate;
}

/// v x* f, the same of a force or a momentum (Featherstone 2.32): Kirchhoff's C(nu) nu for the momentum M nu.
inline Vector6d cross_force(const Vector6d& v, const Vector6d& force) {
  const Eigen::Vector3d linear = v.head<3>(), angular = v.tail<3>();
  Vector6d rate;
  rate << angular.cross(force.head<3>()), angular.cross(force.tail<3>()) + linear.cross(force.head<3>());
  return rate;
}

/// The transform between two frames that are fixed to each other at this instant.
struct SpatialTransform {
  Eigen::Matrix3d parent_from_child = Eigen::Matrix3d::Identity();
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();  ///< the child's origin in the parent

  /// A motion at the parent's origin, as it is at the child's.
  Vector6d motion_to_child(const Vector6d& motion) const {
    Vector6d moved;
    moved << parent_from_child.transpose() * (motion.head<3>() + motion.tail<3>().cross(origin_m)),
        parent_from_child.transpose() * motion.tail<3>();
    return moved;
  }
  /// A force at the child's origin, as it is at the parent's.
  Vector6d force_to_parent(const Vector6d& force) const {
    const Eigen::Vector3d turned = parent_from_child * force.head<3>();
    Vector6d moved;
    moved << turned, parent_from_child * force.tail<3>() + origin_m.cross(turned);
    return moved;
  }
  /// A symmetric inertia at the child's origin, as it is at the parent's (Featherstone 2.66).
  Matrix6d inertia_to_parent(const Matrix6d& inertia) const {
    const Eigen::Matrix3d mass = parent_from_child * inertia.topLeftCorner<3, 3>() * parent_from_child.transpose();
    const Eigen::Matrix3d coupling = parent_from_child * inertia.topRightCorner<3, 3>() * parent_from_child.transpose();
    const Eigen::Matrix3d turning =
        parent_from_child * inertia.bottomRightCorner<3, 3>() * parent_from_child.transpose();
    const Eigen::Matrix3d across = cross_matrix_of(origin_m);
    const Eigen::Matrix3d upper = coupling - mass * across;
    Matrix6d moved;
    moved << mass, upper, upper.transpose(), turning + across * upper - coupling.transpose() * across;
    return moved;
  }
};

}  // namespace uwsim
