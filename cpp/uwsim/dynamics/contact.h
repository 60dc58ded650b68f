#pragma once

#include <Eigen/Core>

#include "uwsim/core/body_state.h"
#include "uwsim/dynamics/contact_arm.h"

namespace uwsim {

inline constexpr int kFixedBody = -1;
inline constexpr int kHull = -1;  ///< in place of a link
/// A contact with a smaller gap, or with an impulse, counts as touching.
inline constexpr double kTouch_m = 1e-3;
/// Slower impacts do not bounce, so that bodies come to rest.
inline constexpr double kBounceThreshold_m_s = 0.05;

/// A point at which body `a` touches body `b` or the fixed world.
struct Contact {
  int a = 0;
  int b = kFixedBody;
  Eigen::Vector3d point_world_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal_world = Eigen::Vector3d::UnitZ();  ///< unit, from b towards a
  double gap_m = 0;                                         ///< negative for an overlap
  double friction = 0;
  double restitution = 0;
  int link_a = kHull, link_b = kHull;  ///< of the bodies' arms

  /// The normal and two tangents, as columns.
  Eigen::Matrix3d directions_world() const;
  /// The minimum velocity along the normal that the contact requires: zero, the rebound velocity by Newton's
  /// restitution if the impact is faster than a threshold, or the (negative) velocity that just closes the gap in this
  /// step. `start_m_s` and `end_m_s` are the velocities at the start of the step and at its end without contacts.
  double least_speed_m_s(double start_m_s, double end_m_s, double step_s) const;
  /// The push velocity along the normal for this step. It removes a fraction of the present overlap and all of the
  /// overlap that this step would add: impulses act throughout the step, so a body that is stopped still moves along
  /// the normal at the mean of its old and new speeds.
  double push_m_s(double start_m_s, double end_m_s, double step_s) const;
};

/// A body as seen by the contact solver.
struct ContactBody {
  Pose world_from_body;
  /// Input: the velocity at the end of the step without contacts. Output: the velocity that the contacts allow.
  Vector6d velocity_body = Vector6d::Zero();
  Vector6d start_velocity_body = Vector6d::Zero();  ///< at the start of the step
  Matrix6d inverse_mass = Matrix6d::Zero();         ///< full (M_RB + M_A)^-1
  /// Output: the total impulse of its contacts about its origin [N s, N m s].
  Vector6d impulse_body = Vector6d::Zero();
  /// Output: a velocity that changes only this step's pose, to separate overlaps without adding energy (split impulse).
  Vector6d push_body = Vector6d::Zero();
  /// Output: the smallest margin of friction, as a fraction of Coulomb's limit, at any loaded contact of its island; 0
  /// if a contact slides or is barely loaded, -1 if the impulses are not exact.
  double grip = -1;
  bool slides = false;  ///< Output: whether a loaded contact of its island slides
  /// Set for a body with an arm, in place of inverse_mass. Its impulse_body counts the contacts of its links,
  /// too; velocity_body, the velocity of its hull, stays that without contacts.
  ContactArm* arm = nullptr;
};

}  // namespace uwsim
