#pragma once

#include "uwsim/core/body_state.h"
#include "uwsim/dynamics/contact.h"

namespace uwsim {

/// Lets a body that its contacts hold be at rest: its velocity is zero and its pose stays the same to the last bit.
///
/// Without this, what a contact's constant force leaves over a step of Runge-Kutta, some 1e-5 m/s, lets a vehicle creep
/// over the bed by millimetres an hour. A body rests while terrain and solids allow no motion. So a body on a slope
/// that would slide or roll from rest at less than 2e-4 m/s^2 does not begin to.
///
/// While a body rests and the loads on it stay the same, so do its contacts, and they need not be found again. That is
/// remembered here, but changes no result: a body that has just been restored goes on in the same way.
class Resting {
 public:
  /// Whether the contacts that `solved` has been through hold the body, and remembers it. `radius_m` is that of the
  /// body.
  bool begins(const ContactBody& solved, const Vector6d& free_velocity_body, double radius_m);
  /// Whether a body in this state, which would move like this without contacts, is known to be held by the fixed world.
  bool lasts(const BodyState& state, const Vector6d& free_velocity_body) const;
  void forget() { is_known_ = false; }

 private:
  bool is_known_ = false;
  Pose world_from_body_ = {};
  Vector6d free_velocity_body_ = Vector6d::Zero();
};

}  // namespace uwsim
