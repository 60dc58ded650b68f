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

/// Performance as a function of command and supply voltage: linear between the points of a sheet, constant beyond its
/// ends, and, for a given command, linear between the voltages of the sheets. Valid within these voltages, in still
/// water, and once the propeller has reached its final speed.
///
/// Thrust is not proportional to the square of the voltage. For the T200 (Blue Robotics, September 2019), interpolating
/// the sheets at 10 and 16 V reproduces the sheet at 14 V to within 0.03 kgf, while the error of (14 / 16)^2 times the
/// thrust at 16 V is several times as large, since the dead band widens as the voltage falls and the losses do not
/// scale with its square.
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

 private:
  std::vector<ThrusterSheet> sheets_;
  std::vector<double> voltages_v_;
};

}  // namespace uwsim
