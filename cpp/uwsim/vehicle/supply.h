#pragma once

#include <optional>
#include <span>

namespace uwsim {

/// The electrical supply of thrusters and fins in a step.
struct Supply {
  bool on = false;
  /// Nothing: the voltage for which the thrust curves hold.
  std::optional<double> voltage_v;
};

/// The current that thrusters draw at the end of a step, by the voltage that they are supplied with: linear between
/// these points.
struct ElectricalLoad {
  std::span<const double> voltages_v;  ///< rising
  std::span<const double> currents_a;
};

}  // namespace uwsim
