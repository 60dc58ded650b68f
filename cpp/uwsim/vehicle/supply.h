#pragma once

#include <optional>
#include <span>

namespace uwsim {

/// The electrical supply of thrusters and fins in a step.
struct Supply {
  bool on = false;
  /// Empty: the voltage for which the thrust curves are valid.
  std::optional<double> voltage_v;
};

/// The current that thrusters draw at the end of a step as a function of the supply voltage, linear between these
/// points.
struct ElectricalLoad {
  std::span<const double> voltages_v;  ///< increasing
  std::span<const double> currents_a;
};

}  // namespace uwsim
