#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <limits>
#include <vector>

#include "uwsim/core/body_state.h"
#include "uwsim/dynamics/joint_law.h"

namespace uwsim {

/// The joints of a body with an arm, as contacts feel them. The velocities of base and joints are one vector, u = (nu,
/// q'), in which the articulated body has the mass matrix M of the composite-rigid-body algorithm (Featherstone 2008,
/// table 6.2). An impulse p at a contact changes u by M^-1 J^T p, all joints that may give way included. Motors,
/// friction and stops are laws between a joint's torque and its speed at the end of the step, to be solved with the
/// contacts.
struct ContactArm {
  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
  struct Joint {
    Vector6d axis;       ///< S, the motion per speed, at the base's origin along its axes
    std::size_t parent;  ///< the joint that moves this one, or kNone
    JointLaw law;
    double torque;        ///< of the law, in the step without contacts
    double speed;         ///< at the end of the step without contacts
    double start_speed;   ///< at its start
    double push_speed{};  ///< Output: changes only this step's position, as ContactBody::push_body
  };
  std::vector<Joint> joints;
  std::vector<std::size_t> joint_of_link;  ///< by link: the joint that moves it, or kNone
  Eigen::MatrixXd mass_factor;             ///< C, lower triangular: M = C C^T

  Eigen::Index size() const { return 6 + static_cast<Eigen::Index>(joints.size()); }
  /// Extends the row of a contact, whose product with nu is the velocity of a point that moves with the base, to that
  /// of a point of a link.
  void extend(const Vector6d& row, int link, Eigen::VectorXd& extended) const;
  /// The joints' part of the velocity along such a row: `of` is Joint::speed or Joint::start_speed.
  double speed_along(const Vector6d& row, int link, double Joint::*of) const;
};

}  // namespace uwsim
