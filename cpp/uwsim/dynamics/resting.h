#pragma once

#include "uwsim/core/body_state.h"
#include "uwsim/dynamics/contact.h"

namespace uwsim {

/// Brings a body that is held by its contacts to rest: its velocity is zero and its pose stays the same to the last
/// bit.
///
/// Without this, the residual of a contact's constant force over a Runge-Kutta step, some 1e-5 m/s, lets a vehicle
/// creep over the bed by millimetres per hour. A body rests while terrain and solids allow no motion. So a body on a
/// slope that would start to slide or roll at less than 2e-4 m/s^2 stays where it is.
///
/// While a body rests and the loads on it stay the same, so do its contacts, and they need not be found again. This is
/// only a cache and changes no result: a body that has just been restored continues in the same way.
class Resting {
 public:
  /// Returns whether the contacts that gave `solved` hold the body, and remembers it. `radius_m` is the body's radius.
  bool begins(const ContactBody& solved, const Vector6d& free_velocity_body, double radius_m);
  /// Whether the fixed world is known to hold a body in this state, which would move at this velocity without contacts.
  bool lasts(const BodyState& state, const Vector6d& free_velocity_body) const;
  void forget() { is_known_ = false; }

 private:
  bool is_known_ = false;
  Pose world_from_body_ = {};
  Vector6d free_velocity_body_ = Vector6d::Zero();
};

}  // namespace uwsim
