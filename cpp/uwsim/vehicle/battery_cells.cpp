#include "uwsim/vehicle/battery_cells.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "uwsim/core/check.h"
#include "uwsim/vehicle/polyline.h"

namespace uwsim {
namespace {

constexpr double kSecondsPerHour = 3600;

}  // namespace

void BatterySpec::check() const {
  const auto require_in = [](double value, double low, double high, const char* path, const char* rule) {
    require(value >= low && value <= high, path, value, rule);
  };
  require_in(capacity_ah, 1e-6, 1e9, "battery.capacity_ah", "must be positive");
  require_in(resistance_ohm, 0, 1e6, "battery.resistance_ohm", "must be 0 ohm or more");
  require_in(cutoff_v, 1e-3, 1e6, "battery.cutoff_v", "must be positive");
  require_in(hotel_w, 0, 1e9, "battery.hotel_w", "must be 0 W or more");
  require_in(initial_charge, 0, 1, "battery.initial_charge", "must be in [0, 1]");
  require(charges.size() >= 2 && charges.size() == open_circuit_v.size(), "battery.open_circuit_v", charges.size(),
          "must have at least 2 points, each a charge and a voltage");
  for (std::size_t k = 0; k < charges.size(); ++k) {
    require(std::isfinite(open_circuit_v[k]) && (k == 0 || open_circuit_v[k] >= open_circuit_v[k - 1]),
            "battery.open_circuit_v", open_circuit_v[k], "voltages must not fall as the charge rises");
    require(k == 0 || charges[k] > charges[k - 1], "battery.open_circuit_v", charges[k], "charges must increase");
  }
  require(charges.front() == 0 && charges.back() == 1, "battery.open_circuit_v", charges.front(),
          "charges must reach from 0 to 1");
  require(open_circuit_v.back() > cutoff_v, "battery.cutoff_v", cutoff_v, "must be below the voltage of full charge");
  // Beyond this, drawing more current would deliver less power.
  require(resistance_ohm * hotel_w < cutoff_v * cutoff_v, "battery.hotel_w", hotel_w,
          "must be less than cutoff_v^2 / resistance_ohm");
}

BatteryCells::BatteryCells(const BatterySpec& spec) : spec_((spec.check(), spec)), charge_(spec.initial_charge) {
  rest();
}

double BatteryCells::open_circuit_v() const { return interpolated(spec_.charges, spec_.open_circuit_v, charge_); }

Supply BatteryCells::supply(const ElectricalLoad& load, double step_s) {
  const Solution found = empty_ || charge_ <= 0 ? Solution{} : solve(load);
  if (found.voltage_v < spec_.cutoff_v) {
    empty_ = true;
    return rest();
  }
  voltage_v_ = found.voltage_v;
  current_a_ = found.current_a;
  charge_ = std::max(0.0, charge_ - current_a_ * step_s / (kSecondsPerHour * spec_.capacity_ah));
  return {true, voltage_v_};
}

/// Between two voltages of the load, I_T(V) = a + b V, and the solution is the upper root of the parabola
/// q(V) = V (V + R (a + b V) - E) + R P, which is negative below it and positive above.
BatteryCells::Solution BatteryCells::solve(const ElectricalLoad& load) const {
  const double r = spec_.resistance_ohm, p = spec_.hotel_w, e = open_circuit_v();
  const auto volts = load.voltages_v, amps = load.currents_a;
  double a = 0, b = 0;
  const auto use_line_below = [&](std::size_t k) {
    b = (amps[k] - amps[k - 1]) / (volts[k] - volts[k - 1]);
    a = amps[k] - b * volts[k];
  };
  const auto q = [&](double v) { return v * (v + r * (a + b * v) - e) + r * p; };
  auto k = static_cast<std::size_t>(std::upper_bound(volts.begin(), volts.end(), spec_.cutoff_v) - volts.begin());
  use_line_below(k);
  if (q(spec_.cutoff_v) > 0) return {};
  while (q(volts[k]) < 0 && k + 1 < volts.size()) use_line_below(++k);
  const double half = 0.5 * (e - r * a) / (1 + r * b);
  const double v = half + std::sqrt(std::max(0.0, half * half - r * p / (1 + r * b)));
  return {v, a + b * v + p / v};
}

Supply BatteryCells::rest() {
  voltage_v_ = open_circuit_v();
  current_a_ = 0;
  return {false, voltage_v_};
}

void BatteryCells::charge_fully() {
  charge_ = 1;
  empty_ = false;
  rest();
}

void BatteryCells::exchange_state(StateArchive& archive) {
  archive(charge_);
  archive(voltage_v_);
  archive(current_a_);
  archive(empty_);
  require(charge_ >= 0 && charge_ <= 1, "state.battery", charge_, "must be a charge in [0, 1]");
}

}  // namespace uwsim
