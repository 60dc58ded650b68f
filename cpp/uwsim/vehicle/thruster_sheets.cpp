#include "uwsim/vehicle/thruster_sheets.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "uwsim/core/check.h"
#include "uwsim/vehicle/polyline.h"

namespace uwsim {
namespace {

void check(const ThrusterSheet& sheet, const std::string& path) {
  const std::size_t points = sheet.commands.size();
  require(std::isfinite(sheet.voltage_v) && sheet.voltage_v > 0, path + ".voltage_v", sheet.voltage_v,
          "must be positive");
  require(points >= 2 && sheet.thrusts_n.size() == points && sheet.currents_a.size() == points &&
              sheet.rpm.size() == points,
          path, points, "must have at least 2 points, each a command, a thrust, a current and revolutions");
  for (std::size_t k = 0; k < points; ++k) {
    require(std::abs(sheet.commands[k]) <= 1, path, sheet.commands[k], "commands must be in [-1, 1]");
    require(k == 0 || sheet.commands[k] > sheet.commands[k - 1], path, sheet.commands[k], "commands must increase");
    require(std::isfinite(sheet.thrusts_n[k]), path, sheet.thrusts_n[k], "thrusts must be finite");
    require(std::isfinite(sheet.currents_a[k]) && sheet.currents_a[k] >= 0, path, sheet.currents_a[k],
            "currents must be 0 A or more");
    require(std::isfinite(sheet.rpm[k]), path, sheet.rpm[k], "revolutions must be finite");
  }
  const double still_n = interpolated(sheet.commands, sheet.thrusts_n, 0);
  require(sheet.commands.front() <= 0 && sheet.commands.back() >= 0 && still_n == 0, path, still_n,
          "command 0 must give 0 N");
}

}  // namespace

ThrusterSheets::ThrusterSheets(std::vector<ThrusterSheet> sheets, std::string_view path) : sheets_(std::move(sheets)) {
  require(sheets_.size() >= 2, path, sheets_.size(), "must be those of at least 2 voltages");
  for (const ThrusterSheet& sheet : sheets_) {
    check(sheet, std::string(path) + "[" + std::to_string(voltages_v_.size()) + "]");
    require(voltages_v_.empty() || sheet.voltage_v > voltages_v_.back(), path, sheet.voltage_v,
            "voltages must increase");
    voltages_v_.push_back(sheet.voltage_v);
  }
}

ThrusterSheets::Point ThrusterSheets::on(std::size_t sheet, double command) const {
  const ThrusterSheet& s = sheets_.at(sheet);
  return {interpolated(s.commands, s.thrusts_n, command), interpolated(s.commands, s.currents_a, command),
          interpolated(s.commands, s.rpm, command)};
}

ThrusterSheets::Point ThrusterSheets::at(double command, double voltage_v) const {
  require(!empty() && voltage_v >= voltages_v_.front() && voltage_v <= voltages_v_.back(), "voltage_v", voltage_v,
          "must be within the voltages of the sheets");
  const auto above = std::lower_bound(voltages_v_.begin() + 1, voltages_v_.end(), voltage_v) - voltages_v_.begin();
  const auto k = static_cast<std::size_t>(above);
  const double share = (voltage_v - voltages_v_[k - 1]) / (voltages_v_[k] - voltages_v_[k - 1]);
  const Point low = on(k - 1, command), high = on(k, command);
  const double low_v = voltages_v_[k - 1], high_v = voltages_v_[k];
  const double root = std::lerp(root_per_volt(low.thrust_n, low_v), root_per_volt(high.thrust_n, high_v), share);
  return {thrust_n(root, voltage_v), std::lerp(low.current_a, high.current_a, share),
          voltage_v * std::lerp(low.rpm / low_v, high.rpm / high_v, share)};
}

double ThrusterSheets::root_per_volt(double thrust_n, double voltage_v) {
  return std::copysign(std::sqrt(std::abs(thrust_n)), thrust_n) / voltage_v;
}

double ThrusterSheets::thrust_n(double root_per_volt, double voltage_v) {
  const double root = root_per_volt * voltage_v;
  return root * std::abs(root);
}

}  // namespace uwsim
