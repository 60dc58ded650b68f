#pragma once

#include "uwsim/core/body_state.h"
#include "uwsim/vehicle/craft.h"

namespace uwsim {

/// Moves a pose along a body-frame velocity for a time: exact for constant velocity in translation to first order in
/// the turn, and keeps the quaternion a unit.
Pose displaced(const Pose& pose, const Vector6d& velocity_body, double duration_s);

/// What acts on a body beside gravity and water, held over a step: force and torque about its origin [N, N m].
struct Loads {
  Vector6d body = Vector6d::Zero();   ///< turns with the body: its actuators
  Vector6d world = Vector6d::Zero();  ///< keeps its direction in the world: its contacts
};

/// One step from `time_s` by classical Runge-Kutta of fourth order, pose and velocity together.
BodyState advance(const Craft& craft, const BodyState& state, const Loads& loads, const WaterField& water,
                  double time_s, double step_s);

}  // namespace uwsim
