#pragma once

#include <array>
#include <memory>

#include "uwsim/core/body_state.h"
#include "uwsim/core/water_field.h"
#include "uwsim/vehicle/actuators.h"
#include "uwsim/vehicle/hydrodynamics.h"

namespace uwsim {

/// A controller's model of its vehicle, from the vehicle's file: the equations of motion in deep, still water, the
/// forces that thrusters produce there and, for axes driven only by fins, the torques of fins at small angles in flow
/// from ahead.
class ControlModel {
 public:
  /// Throws InvalidValue for invalid actuators.
  ControlModel(std::shared_ptr<const Craft> craft, const ActuatorsSpec& actuators, double density_kg_m3,
               double gravity_m_s2 = EvenWater().gravity_m_s2);

  /// The wrench for an acceleration at a given velocity and attitude, tau = M (nu' - nu'_0), where nu'_0 is the
  /// acceleration without actuators: drag, Coriolis and restoring forces are fed forward. Six-vectors in body axes; [N,
  /// N m].
  Vector6d wrench_body(const Eigen::Matrix3d& world_from_body, const Vector6d& velocity,
                       const Vector6d& acceleration) const;
  /// The change in acceleration caused by a change of the wrench.
  Vector6d change_body(const Vector6d& wrench_body) const { return inverse_mass_ * wrench_body; }
  /// The wrench with components about axes that no actuator drives set to 0.
  Vector6d driven_part(const Vector6d& wrench_body) const;
  /// The part of a requested wrench that the thrusters, and the fins at the given forward speed, can deliver:
  /// components about axes that they do not drive are removed, and the rest is scaled down to the thrusters' limits.
  /// Torque takes priority over force; both keep their direction. With across_first, force across the vehicle takes
  /// priority over force along it. Fins reach their limits about each axis separately.
  Vector6d reachable(const Vector6d& wrench_body, double surge_m_s, bool across_first = false) const;
  /// The efforts for a reachable wrench, each in [-1, 1].
  Vector6d effort(const Vector6d& wrench_body, double surge_m_s) const;
  /// For each axis, surge to yaw, whether thrusters or fins drive it.
  const std::array<bool, 6>& driven() const { return driven_; }

 private:
  Vector6d fin_limit(double surge_m_s) const;
  Vector6d by_thrusters(const Vector6d& wrench_body, bool across_first) const;

  std::shared_ptr<const Craft> craft_;
  Actuators actuators_;
  EvenWater water_;
  Matrix6d mass_, inverse_mass_;
  Vector6d fin_torque_;  // of axes that only fins drive, at 1 N/m^2
  std::array<bool, 6> driven_{};
};

}  // namespace uwsim
