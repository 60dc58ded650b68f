#pragma once

#include <string_view>
#include <vector>

namespace uwsim {

/// Measured thrust in still water as a function of a command in [-1, 1]: linear between the points of a table, constant
/// beyond its ends. A dead band is an interval of zero thrust around command 0.
class ThrustCurve {
 public:
  /// Thrust equal to the command [N].
  ThrustCurve() : ThrustCurve({-1, 1}, {-1, 1}) {}
  /// Throws InvalidValue unless commands increase within [-1, 1], thrusts [N] never decrease, and command 0 maps to 0
  /// N.
  ThrustCurve(std::vector<double> commands, std::vector<double> thrusts_n, std::string_view path = "thrust_curve");

  double thrust_n(double command) const;
  /// The inverse: a command that produces this thrust. Returns 0 for 0 N, and the end of the table for a thrust beyond
  /// it.
  double command(double thrust_n) const;
  double lowest_n() const { return thrusts_n_.front(); }
  double highest_n() const { return thrusts_n_.back(); }

 private:
  std::vector<double> commands_;
  std::vector<double> thrusts_n_;
};

}  // namespace uwsim
