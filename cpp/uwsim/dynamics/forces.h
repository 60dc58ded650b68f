#pragma once

#include "uwsim/dynamics/moved_body.h"

namespace uwsim {

/// The wrenches on a body, means over a step, body frame, at the body's origin [N, N m]. Each stage of the step's
/// Runge-Kutta method has the weight that it has in the step, so their sum is M_RB (nu_1 - nu_0) / dt, the rigid body's
/// mass times the change of its velocity in the step, to rounding error.
struct Forces {
  Craft::Terms craft;  ///< the body in the water; its drag with that of plants
  Vector6d actuators = Vector6d::Zero();
  Vector6d applied = Vector6d::Zero();  ///< by apply_wrench
  Vector6d wind = Vector6d::Zero();
  Vector6d tether = Vector6d::Zero();
  Vector6d contact = Vector6d::Zero();
  Vector6d arm = Vector6d::Zero();   ///< of its links, at the joints that hold them
  Vector6d dock = Vector6d::Zero();  ///< what holds a docked vehicle

  Vector6d sum() const;
};

/// The forces in the body's last step. Without one, those at this instant, apart from actuators and contacts; for a
/// body that is held, the dock's balances the others. What stops a body, or keeps it at rest, is its contacts.
/// `canopy_world`: what plants exerted on it in that step, or exert now (canopy.h).
Forces forces_on(const MovedBody& body, const Vector6d& canopy_world, const WaterField& water, double time_s,
                 double step_s);

}  // namespace uwsim
