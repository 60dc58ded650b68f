#pragma once

#include "uwsim/core/body_state.h"
#include "uwsim/vehicle/hydrodynamics.h"

namespace uwsim {

/// The pose after moving at a constant body-frame velocity for a given time: the rotation is exact, the translation is
/// first-order in the rotation.
Pose displaced(const Pose& pose, const Vector6d& velocity_body, double duration_s);

/// Loads on a body other than gravity and water, constant over a step: force and torque about the body's origin [N, N
/// m].
struct Loads {
  Vector6d body = Vector6d::Zero();   ///< constant in the body frame: its actuators
  Vector6d world = Vector6d::Zero();  ///< constant in the world frame: its contacts
};

/// The state after one step from `time_s`: classical fourth-order Runge-Kutta, with pose and velocity integrated
/// together.
BodyState advance(const Craft& craft, const BodyState& state, const Loads& loads, const WaterField& water,
                  double time_s, double step_s);

}  // namespace uwsim
