#pragma once

#include <string>
#include <vector>

#include "uwsim/core/state_archive.h"
#include "uwsim/vehicle/supply.h"

namespace uwsim {

/// The parameters of a battery that stores charge.
struct BatterySpec {
  double capacity_ah = 1;
  std::vector<double> charges;         ///< fractions of the capacity, rising from 0 to 1
  std::vector<double> open_circuit_v;  ///< at each charge, at rest; never falling
  double resistance_ohm = 0;
  double cutoff_v = 0;        ///< below this voltage it switches off
  double hotel_w = 0;         ///< power of everything but the thrusters
  double initial_charge = 1;  ///< fraction

  /// Throws InvalidValue naming the field.
  void check() const;
};

/// Cells behind an internal resistance: the voltage at the terminals is V = E(s) - R I, with the open-circuit voltage E
/// by charge s, as in the models of Shepherd 1965 and Tremblay et al. 2007, "A Generic Battery Model for the Dynamic
/// Simulation of Hybrid Electric Vehicles", without their exponential transients. The current is the sum of the
/// thrusters' current, which depends on V, and the current of a constant power P: I = I_T(V) + P / V. This is solved
/// for V in closed form between two voltages of the thrusters' sheets. Charge is the integral of current. Once the
/// voltage falls below a limit, or the charge is used up, the battery stays off until it is charged.
///
/// Valid at one temperature, for discharges slower than the cells' relaxation (minutes), and above a charge of about 10
/// %; below that, and in cold water, the resistance of real cells rises.
class BatteryCells {
 public:
  /// Throws InvalidValue: see BatterySpec::check.
  explicit BatteryCells(const BatterySpec& spec);

  const BatterySpec& spec() const { return spec_; }
  /// Supplies a load for one step.
  Supply supply(const ElectricalLoad& load, double step_s);
  /// Supplies nothing.
  Supply rest();
  void charge_fully();

  double charge_ah() const { return charge_ * spec_.capacity_ah; }
  bool empty() const { return empty_; }
  double voltage_v() const { return voltage_v_; }  ///< at the terminals, in the last step
  double current_a() const { return current_a_; }  ///< out of the terminals, in the last step
  /// The usable charge in percent of the capacity; 0 once it has switched off.
  double charge_percent() const { return empty_ ? 0 : 100 * charge_; }

  /// Throws InvalidValue.
  void exchange_state(StateArchive& archive);

 private:
  /// Voltage and current under a load; 0 V if the voltage would fall below the cut-off.
  struct Solution {
    double voltage_v = 0, current_a = 0;
  };
  Solution solve(const ElectricalLoad& load) const;
  double open_circuit_v() const;

  BatterySpec spec_;
  double charge_ = 0;  // fraction of the capacity
  double voltage_v_ = 0;
  double current_a_ = 0;
  bool empty_ = false;
};

}  // namespace uwsim
