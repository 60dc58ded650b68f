#pragma once

#include <Eigen/Core>
#include <limits>
#include <string>

#include "uwsim/core/body_state.h"
#include "uwsim/core/state_archive.h"
#include "uwsim/vehicle/thrust_curve.h"

namespace uwsim {

/// A propeller with its motor, body frame.
struct ThrusterParameters {
  std::string name;
  Eigen::Vector3d position_body_m = Eigen::Vector3d::Zero();  ///< hub
  Eigen::Vector3d axis_body = Eigen::Vector3d::UnitX();       ///< where a positive thrust pushes the vehicle, unit
  ThrustCurve curve;                                          ///< in still water
  double time_constant_s = 0;                                 ///< of the thrust; 0 follows at once
  double diameter_m = 0.1;
  /// Bollard thrust coefficient T / (rho n^2 D^4), from which the revolutions follow. [-]
  double bollard_coefficient = 0.45;
  /// Advance ratio u_a / (n D) at which the thrust is lost; infinity for none. [-]
  double zero_thrust_advance_ratio = std::numeric_limits<double>::infinity();
  double torque_per_thrust_m = 0;  ///< k_q = D K_Q / K_T
  int spin = 1;                    ///< turns right-handed (+1) or left-handed (-1) about its axis as it thrusts ahead

  /// Throws InvalidValue that names thruster and field.
  void check() const;
};

/// A thruster that follows its commands.
///
/// Still-water thrust T0 follows the curve's with a first-order lag, advanced exactly over a step. What reaches the
/// hull is the bilinear model of Fossen 2011, "Handbook of Marine Craft Hydrodynamics and Motion Control", sec. 9.1,
///
///   T = T_nn |n| n - T_nu |n| u_a = T0 - (D / J_0) sqrt(rho K_T0 |T0|) u_a,
///
/// u_a the hub's speed through the water along the axis, and the propeller's torque, k_q T against its spin. Valid for
/// advance ratios from about -J_0 / 2 to J_0; inflow across the axis and neighbours' jets do nothing.
class Thruster {
 public:
  /// Throws InvalidValue from the parameters' check.
  explicit Thruster(ThrusterParameters parameters);

  const ThrusterParameters& parameters() const { return parameters_; }
  /// Force along the axis and its moment about the body's origin, of 1 N; without the propeller's torque.
  const Vector6d& column() const { return column_; }

  /// In [-1, 1], held; checked by the caller.
  void set_command(double command);
  double command() const { return command_; }
  /// Lets a step pass, under power or without.
  void advance(double step_s, bool powered);
  /// Still-water thrust now [N].
  double thrust_n() const { return thrust_n_; }

  /// Adds the mean force and torque over the last step (body frame, at the origin) of a thruster that moves with
  /// `through_water` (6,) [m/s, rad/s] and has `submerged` of its disc in water.
  void add_wrench(const Vector6d& through_water, double density_kg_m3, double submerged, Vector6d& tau_body) const;
  /// Share of the propeller's disc under a level surface `height_m` above its hub; `axis_up` is the vertical part of
  /// the axis.
  double submerged_share(double height_m, double axis_up) const;

  /// Saves or restores how it stands.
  void exchange_state(StateArchive& archive);

 private:
  ThrusterParameters parameters_;
  Vector6d column_;            // of thrust
  Vector6d column_with_spin_;  // of thrust and torque together
  double loss_ = 0;            // D sqrt(K_T0) / J_0 [m]
  double command_ = 0;
  double target_n_ = 0;
  double thrust_n_ = 0;
  double mean_thrust_n_ = 0;  // over the last step
  double step_s_ = 0;         // that decay and mean belong to
  double decay_ = 0;
  double mean_share_ = 0;  // of the initial difference that is there on average
};

}  // namespace uwsim
