#pragma once

#include "uwsim/core/body_state.h"
#include "uwsim/dynamics/contact.h"

namespace uwsim {

/// Brings a body that is held by its contacts to rest: its velocity is set to zero and its pose stays bitwise
/// identical.
///
/// Without this, integrating a constant contact force over a Runge-Kutta step leaves a residual velocity of about 1e-5
/// m/s, which would let a vehicle creep across the bed by millimetres per hour. A body rests as long as terrain and
/// solids allow no motion. Consequently, a body on a slope that would start to slide or roll at less than 2e-4 m/s^2
/// stays where it is.
///
/// While a body rests and the loads on it stay the same, its contacts stay the same too and need not be recomputed.
/// This is only a cache and changes no result: a body that has just been restored continues in the same way.
class Resting {
 public:
  /// Returns whether the contacts that produced `solved` hold the body, and stores the result. `radius_m` is the body's
  /// radius.
  bool begins(const ContactBody& solved, const Vector6d& free_velocity_body, double radius_m);
  /// Whether a body is known to be held by the fixed world, given its state and the velocity that it would have without
  /// contacts.
  bool lasts(const BodyState& state, const Vector6d& free_velocity_body) const;
  void forget() { is_known_ = false; }

 private:
  bool is_known_ = false;
  Pose world_from_body_ = {};
  Vector6d free_velocity_body_ = Vector6d::Zero();
};

}  // namespace uwsim
