#pragma once

#include <Eigen/Core>
#include <array>

#include "uwsim/control/control_model.h"
#include "uwsim/control/motion_estimate.h"
#include "uwsim/control/pid.h"

namespace uwsim {

/// The cascade of one axis: a position error commands a velocity, a velocity error an acceleration.
struct LoopGains {
  double position_1_s = 0;    ///< velocity per unit of position error [1/s]
  double velocity_1_s = 0;    ///< acceleration per unit of velocity error [1/s]
  double integral_1_s2 = 0;   ///< acceleration per unit of the integrated velocity error [1/s^2]
  double acceleration_1 = 0;  ///< fraction of the measured acceleration that is opposed, like added inertia
};

struct ControlGains {
  std::array<LoopGains, 6> loops;  ///< surge to yaw
  double filter_s = 0.1;           ///< time constant of the filter for the measured acceleration
  double tracking_s = 1;           ///< time constant of the anti-windup; see PidGains
  double speed_max_m_s = 1;        ///< horizontal, towards a position
  double climb_max_m_s = 0.5;      ///< vertical, towards a position
  double turn_max_rad_s = 0.5;     ///< towards an attitude
  double acceleration_max_m_s2 = 0.5;
  double turn_acceleration_max_rad_s2 = 1;

  /// Throws InvalidValue naming the field.
  void check(double period_s) const;
};

/// The motion to maintain. An axis whose position is NaN is controlled by velocity alone.
struct MotionTarget {
  Eigen::Vector3d position_world_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_world_m_s = Eigen::Vector3d::Zero();  ///< rate of change of the position, fed forward
  double roll_rad = 0;
  double pitch_rad = 0;
  double heading_rad = 0;
  bool across_first = false;  ///< beyond the limits, force across the vehicle takes priority over force along it
};

/// The state carried from one control period to the next.
struct MotionMemory {
  Eigen::Vector3d integral_world = Eigen::Vector3d::Zero();      ///< of surge, sway, heave [m/s^2]
  Eigen::Vector3d integral_body = Eigen::Vector3d::Zero();       ///< of roll, pitch, yaw [rad/s^2]
  Eigen::Vector3d velocity_world_m_s = Eigen::Vector3d::Zero();  ///< the last reference
  Eigen::Vector3d turn_body_rad_s = Eigen::Vector3d::Zero();     ///< the last reference
  Vector6d measured_body = Vector6d::Zero();                     ///< the last velocity
  Vector6d derivative_body = Vector6d::Zero();                   ///< of the filters
  bool begun = false;
};

/// Position, depth, heading, attitude and velocity control by a cascade (Fossen 2021, "Handbook of Marine Craft
/// Hydrodynamics and Motion Control", 2nd ed., ch. 15).
///
/// Errors of position and attitude determine reference velocities: a gain times the error near the target; farther
/// away, the highest velocity from which the vehicle can stop there. Their rates of change are limited (a reference
/// model, sec. 12.1). A PID loop for each axis converts velocity errors to accelerations a, and tau = M a - f(eta,
/// nu_ref) feeds forward drag, Coriolis and restoring forces from the vehicle's model. The attitude error is the
/// remaining rotation vector. The integrals of surge, sway and heave are kept in world axes, because the disturbances
/// that they counteract (a current or a wrong trim) do not turn with the vehicle. The model assumes deep water at rest;
/// the loops correct for everything else. A vehicle without vertical thrusters climbs by pitching.
class MotionController {
 public:
  /// Throws InvalidValue for invalid gains.
  MotionController(ControlModel model, const ControlGains& gains, double period_s);

  /// Computes the efforts of one control period, surge to yaw, for reaching a target.
  Vector6d reach(const MotionEstimate& estimate, const MotionTarget& target);
  /// Computes the efforts of one control period for maintaining a velocity in body axes, [m/s] and [rad/s]. Roll and
  /// pitch are kept level unless a rate about them is requested.
  Vector6d hold_velocity(const MotionEstimate& estimate, const Vector6d& velocity_body);

  const ControlModel& model() const { return model_; }
  /// The fraction of the requested force that the thrusters delivered in the last period.
  double force_share() const { return force_share_; }
  MotionMemory memory;

 private:
  Eigen::Vector3d turn_towards(const MotionEstimate& estimate, const MotionTarget& target) const;
  Vector6d track(const MotionEstimate& estimate, const Eigen::Vector3d& velocity_world_m_s,
                 const Eigen::Vector3d& turn_body_rad_s, bool across_first);

  ControlModel model_;
  ControlGains gains_;
  double period_s_;
  double force_share_ = 1;
};

}  // namespace uwsim
