#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "uwsim/core/body_state.h"
#include "uwsim/core/state_archive.h"
#include "uwsim/vehicle/slipstream.h"
#include "uwsim/vehicle/supply.h"
#include "uwsim/vehicle/thrust_curve.h"
#include "uwsim/vehicle/thruster_sheets.h"

namespace uwsim {

/// A propeller and its motor, in the body frame.
struct ThrusterParameters {
  std::string name;
  Eigen::Vector3d position_body_m = Eigen::Vector3d::Zero();  ///< position of the hub
  Eigen::Vector3d axis_body = Eigen::Vector3d::UnitX();       ///< unit, direction of a positive thrust
  ThrustCurve curve;           ///< in still water, at the voltage at which it was measured
  ThrusterSheets sheets;       ///< for a supply with a variable voltage; otherwise empty
  double time_constant_s = 0;  ///< of the thrust; 0 for no lag
  double diameter_m = 0.1;
  /// Thrust coefficient at zero speed (bollard pull), T / (rho n^2 D^4), from which the shaft speed is computed [-].
  double bollard_coefficient = 0.45;
  /// Advance ratio u_a / (n D) at which the thrust vanishes; infinity if it never does [-].
  double zero_thrust_advance_ratio = std::numeric_limits<double>::infinity();
  double torque_per_thrust_m = 0;  ///< k_q = D K_Q / K_T
  int spin = 1;                    ///< +1 right-handed, -1 left-handed about the axis when thrusting ahead
  /// Its force is not a propeller's but buoyancy or weight: along the world's vertical, whatever the hull's attitude,
  /// without inflow and also above the water; positive up. `axis_body` must then be z.
  bool is_vertical = false;
  /// Where the opposite of a vertical force acts, as if weight were moved from here to `position_body_m`.
  std::optional<Eigen::Vector3d> counter_body_m;
  bool ventilates = false;  ///< draws air near the surface, see `submerged_fraction`
  double health = 1;        ///< fraction of the thrust that remains after a fault; ignored by the allocation

  /// Throws InvalidValue naming the thruster and the field.
  void check() const;
};

/// A thruster that follows its commands.
///
/// The still-water thrust T0 follows the curve's thrust with a first-order lag, integrated exactly over a step. The
/// force on the vehicle follows the bilinear model of Fossen 2011, "Handbook of Marine Craft Hydrodynamics and Motion
/// Control", sec. 9.1,
///
///   T = T_nn |n| n - T_nu |n| u_a = T0 - (D / J_0) sqrt(rho K_T0 |T0|) u_a,
///
/// where u_a is the hub's speed through the water along the axis, and the propeller's torque is k_q T, opposite to its
/// spin. Valid for advance ratios from about -J_0 / 2 to J_0. Inflow across the axis and the jets of other thrusters
/// are neglected; fins may be in its slipstream.
///
/// With a supply voltage, thrust and current follow the values of the sheets, both with the same lag. Inflow does not
/// affect the current.
class Thruster {
 public:
  /// Throws InvalidValue; see ThrusterParameters::check.
  explicit Thruster(ThrusterParameters parameters);

  const ThrusterParameters& parameters() const { return parameters_; }
  /// Force and moment about the body's origin per 1 N of thrust, without the propeller's torque.
  const Vector6d& column() const { return column_; }

  /// Sets the command, in [-1, 1], which stays in effect until the next one. The caller checks the range.
  void set_command(double command);
  double command() const { return command_; }
  /// Adds, for each voltage of the sheets, the current that the thruster would draw at the end of the next step [A].
  void add_current(double step_s, std::span<double> currents_a);
  /// Advances the thrust by one step; without power, thrust decays to 0 and no current flows.
  void advance(double step_s, const Supply& supply);
  /// Present still-water thrust [N].
  double thrust_n() const { return thrust_n_; }
  /// Present current; 0 without a supply voltage [A].
  double current_a() const { return current_a_; }

  /// Adds mean force and torque over the last step (body frame, at the origin) for a vehicle that moves at
  /// `through_water` (6,) [m/s, rad/s] with the fraction `submerged` of the propeller's disc under water.
  void add_wrench(const Vector6d& through_water, double density_kg_m3, double submerged, Vector6d& tau_body) const;
  /// The propeller's jet at this place (body frame), for the same motion.
  Slipstream slipstream(const Vector6d& through_water, double density_kg_m3, double submerged,
                        const Eigen::Vector3d& place_body_m) const;
  /// Adds the mean force and torque of a vertical thruster over the last step; `up_body`: the world's vertical.
  void add_vertical(const Eigen::Vector3d& up_body, Vector6d& tau_body) const;
  /// Fraction of the propeller's disc below a level surface `height_m` above its hub. `axis_up`: vertical component of
  /// the axis. With `ventilates`, in its place the share of the thrust that a loaded propeller keeps as it draws air
  /// (Minsaas, Thon and Kauczynski 1983, in Smogeli 2006, "Control of marine propellers", sec. 2.3), with radius R:
  ///
  ///   beta = 1 - 0.675 (1 - 0.769 h / R)^1.258 for -0.48 < h / R < 1.3
  ///
  /// 0 above and 1 below, where the formula itself is 0 and 1 within 0.003; measured with level axes. The papers were
  /// not at hand.
  double submerged_fraction(double height_m, double axis_up) const;

  /// Saves or restores the command, the thrust and, with sheets, the current; the targets follow from the command.
  void exchange_state(StateArchive& archive);

 private:
  void use_step(double step_s);
  double thrust_at(double inflow_m_s, double density_kg_m3) const;

  ThrusterParameters parameters_;
  Vector6d column_;              // for 1 N of thrust
  Vector6d column_with_torque_;  // for 1 N of thrust and the associated torque
  double loss_ = 0;              // D sqrt(K_T0) / J_0 [m]
  double command_ = 0;
  double target_n_ = 0;
  std::vector<double> roots_, targets_a_;  // by voltage of the sheets; roots_: see ThrusterSheets::root_per_volt
  double thrust_n_ = 0;
  double mean_thrust_n_ = 0;  // over the last step
  double current_a_ = 0;
  double step_s_ = 0;  // the step for which decay_ and mean_decay_ were computed
  double decay_ = 0;
  double mean_decay_ = 0;  // mean over the step, relative to its start
};

}  // namespace uwsim
