#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

namespace uwsim {

/// The measured performance of a thruster in still water at one supply voltage.
struct ThrusterSheet {
  double voltage_v = 0;
  std::vector<double> commands;    ///< in [-1, 1], increasing
  std::vector<double> thrusts_n;   ///< at each command; 0 at command 0
  std::vector<double> currents_a;  ///< drawn from the supply
  std::vector<double> rpm;         ///< revolutions per minute
};

/// Performance as a function of command and supply voltage: linear between the points of a sheet, and constant beyond
/// its ends. For a given command, three quantities are linear between the voltages of the sheets: the speed per volt,
/// the signed square root of the thrust per volt, and the current. A propeller's thrust in still water is k n^2 (Fossen
/// 2011, sec. 9.1), so its root per volt follows the speed per volt, which changes slowly with the voltage. Valid
/// within the sheets' voltages, in still water, and once the propeller has reached its final speed.
///
/// For the T200 (Blue Robotics, September 2019), the sheets at 10 and 16 V reproduce the thrust at 14 V to within 0.027
/// kgf rms, and those at 14 and 20 V the thrust at 16 V to within 0.047 kgf; with linear interpolation of the thrust
/// itself, the errors are 0.026 and 0.095 kgf. Thrust is not proportional to the square of the voltage, since the dead
/// band widens as the voltage falls and the losses do not scale with its square.
class ThrusterSheets {
 public:
  struct Point {
    double thrust_n = 0, current_a = 0, rpm = 0;
  };

  /// No sheets.
  ThrusterSheets() = default;
  /// Throws InvalidValue unless voltages increase, each sheet's commands increase, and no current is negative.
  explicit ThrusterSheets(std::vector<ThrusterSheet> sheets, std::string_view path = "sheets");

  bool empty() const { return sheets_.empty(); }
  const std::vector<double>& voltages_v() const { return voltages_v_; }
  /// Performance at the voltage of one sheet.
  Point on(std::size_t sheet, double command) const;
  /// Throws InvalidValue for a voltage outside the range of the sheets.
  Point at(double command, double voltage_v) const;

  /// The signed square root of a thrust, per volt [sqrt(N) / V].
  static double root_per_volt(double thrust_n, double voltage_v);
  /// The thrust that has this root per volt at a voltage [N].
  static double thrust_n(double root_per_volt, double voltage_v);

 private:
  std::vector<ThrusterSheet> sheets_;
  std::vector<double> voltages_v_;
};

}  // namespace uwsim
