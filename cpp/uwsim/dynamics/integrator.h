#pragma once

#include <array>

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

  /// Their sum along the body's axes.
  Vector6d at(const Eigen::Quaterniond& world_from_body) const;
};

/// A wrench with its axes turned from the world's to the body's.
Vector6d in_body_axes(const Vector6d& wrench_world, const Eigen::Quaterniond& world_from_body);

/// Rates of change of a state.
struct Rate {
  Eigen::Vector3d position;
  Eigen::Vector4d quaternion;  ///< x y z w
  Vector6d velocity;           ///< body frame
};

/// The rates of a state whose velocity changes at `acceleration_body`, nu'.
Rate rate_at(const BodyState& state, const Vector6d& acceleration_body);
/// The state that is reached at constant rates.
BodyState moved_at(const BodyState& state, const Rate& rate, double time_s);

/// A stage of a Runge-Kutta step.
struct Stage {
  BodyState state;
  double time_s;
  Rate rate;
};

/// The weights of the four stages in the step.
inline constexpr double kStageShares[] = {1.0 / 6, 2.0 / 6, 2.0 / 6, 1.0 / 6};

/// The stages from which `advance` makes its step. `extra_body`: wrenches that act on the body besides, in each stage;
/// may be null.
std::array<Stage, 4> stages(const Craft& craft, const BodyState& state, const Loads& loads, const WaterField& water,
                            double time_s, double step_s, const std::array<Vector6d, 4>* extra_body = nullptr);

/// The state after one step from `time_s`: classical fourth-order Runge-Kutta, with pose and velocity integrated
/// together.
BodyState advance(const Craft& craft, const BodyState& state, const Loads& loads, const WaterField& water,
                  double time_s, double step_s);

}  // namespace uwsim
