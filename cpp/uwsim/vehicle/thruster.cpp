#include "uwsim/vehicle/thruster.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "uwsim/core/check.h"
#include "uwsim/vehicle/polyline.h"

namespace uwsim {

namespace {

// Below this difference, a thrust or a current is set to its target. An exponential never reaches its target: with a
// lag of 75 ms, the difference is a subnormal number after 54 s, which makes operations many times slower.
constexpr double kReached = 1e-30;

/// The difference between a value and its target.
double difference(double value, double target) {
  const double left = value - target;
  return std::abs(left) < kReached ? 0 : left;
}

}  // namespace

void ThrusterParameters::check() const {
  const std::string path = "thrusters." + name;
  require(position_body_m.allFinite(), path + ".position_m", position_body_m.transpose(), "must be finite");
  require(std::abs(axis_body.norm() - 1) < 1e-6, path + ".axis", axis_body.transpose(), "must be a unit vector");
  require(std::isfinite(time_constant_s) && time_constant_s >= 0, path + ".time_constant_s", time_constant_s,
          "must be 0 s or more");
  require(std::isfinite(diameter_m) && diameter_m > 0, path + ".diameter_m", diameter_m, "must be positive");
  require(std::isfinite(bollard_coefficient) && bollard_coefficient > 0, path + ".bollard_coefficient",
          bollard_coefficient, "must be positive");
  require(zero_thrust_advance_ratio > 0, path + ".zero_thrust_advance_ratio", zero_thrust_advance_ratio,
          "must be positive");
  require(std::isfinite(torque_per_thrust_m) && torque_per_thrust_m >= 0, path + ".torque_per_thrust_m",
          torque_per_thrust_m, "must be 0 m or more");
  require(health >= 0 && health <= 1, path + ".health", health, "must be in [0, 1]");
  require(!is_vertical || axis_body.z() > 1 - 1e-9, path + ".axis", axis_body.transpose(),
          "must be [0, 0, 1] for a vertical force");
  require(!counter_body_m || (is_vertical && counter_body_m->allFinite()), path + ".moved_from_m", "given",
          "is only for a vertical force");
  require(spin == 1 || spin == -1, path + ".spin", spin, "must be 1 (right-handed) or -1 (left-handed)");
}

Thruster::Thruster(ThrusterParameters parameters) : parameters_(std::move(parameters)) {
  parameters_.check();
  const ThrusterParameters& p = parameters_;
  column_ << p.axis_body, p.position_body_m.cross(p.axis_body);
  if (p.counter_body_m) column_ << Eigen::Vector3d::Zero(), (p.position_body_m - *p.counter_body_m).cross(p.axis_body);
  column_with_torque_ = column_;
  column_with_torque_.tail<3>() -= p.spin * p.torque_per_thrust_m * p.axis_body;
  loss_ = p.diameter_m * std::sqrt(p.bollard_coefficient) / p.zero_thrust_advance_ratio;
  roots_.resize(p.sheets.voltages_v().size());
  targets_a_.resize(roots_.size());
  set_command(0);
}

void Thruster::set_command(double command) {
  command_ = command;
  target_n_ = parameters_.health * parameters_.curve.thrust_n(command);
  for (std::size_t k = 0; k < roots_.size(); ++k) {
    const ThrusterSheets::Point point = parameters_.sheets.on(k, command);
    const double thrust_n = parameters_.health * point.thrust_n;
    roots_[k] = ThrusterSheets::root_per_volt(thrust_n, parameters_.sheets.voltages_v()[k]);
    targets_a_[k] = parameters_.health * point.current_a;
  }
}

void Thruster::use_step(double step_s) {
  if (step_s == step_s_) return;
  const double steps = step_s / parameters_.time_constant_s;  // infinite if there is no lag
  step_s_ = step_s;
  decay_ = std::exp(-steps);
  mean_decay_ = -std::expm1(-steps) / steps;
}

void Thruster::add_current(double step_s, std::span<double> currents_a) {
  use_step(step_s);
  for (std::size_t k = 0; k < targets_a_.size(); ++k) {
    currents_a[k] += targets_a_[k] + difference(current_a_, targets_a_[k]) * decay_;
  }
}

void Thruster::advance(double step_s, const Supply& supply) {
  use_step(step_s);
  double target_n = target_n_, target_a = 0;
  if (supply.voltage_v && !roots_.empty()) {
    const std::vector<double>& voltages_v = parameters_.sheets.voltages_v();
    const double voltage_v = std::clamp(*supply.voltage_v, voltages_v.front(), voltages_v.back());
    target_n = ThrusterSheets::thrust_n(interpolated(voltages_v, roots_, voltage_v), voltage_v);
    target_a = interpolated(voltages_v, targets_a_, voltage_v);
  }
  if (!supply.on) target_n = target_a = current_a_ = 0;
  const double left_n = difference(thrust_n_, target_n);
  mean_thrust_n_ = target_n + left_n * mean_decay_;
  thrust_n_ = target_n + left_n * decay_;
  current_a_ = target_a + difference(current_a_, target_a) * decay_;
}

void Thruster::exchange_state(StateArchive& archive) {
  archive(command_);
  set_command(command_);
  archive(thrust_n_);
  archive(mean_thrust_n_);
  if (!parameters_.sheets.empty()) archive(current_a_);
}

void Thruster::add_wrench(const Vector6d& through_water, double density_kg_m3, double submerged,
                          Vector6d& tau_body) const {
  if (mean_thrust_n_ == 0) return;
  const double thrust = thrust_at(column_.dot(through_water), density_kg_m3);
  tau_body += submerged * thrust * column_with_torque_;
}

double Thruster::thrust_at(double inflow_m_s, double density_kg_m3) const {
  return mean_thrust_n_ - loss_ * std::sqrt(density_kg_m3 * std::abs(mean_thrust_n_)) * inflow_m_s;
}

Slipstream Thruster::slipstream(const Vector6d& through_water, double density_kg_m3, double submerged,
                                const Eigen::Vector3d& place_body_m) const {
  const double inflow_m_s = column_.dot(through_water);
  const double thrust_n = submerged * thrust_at(inflow_m_s, density_kg_m3);
  return Slipstream::behind(thrust_n, inflow_m_s, density_kg_m3, 0.5 * parameters_.diameter_m,
                            parameters_.position_body_m, parameters_.axis_body, place_body_m);
}

void Thruster::add_vertical(const Eigen::Vector3d& up_body, Vector6d& tau_body) const {
  const ThrusterParameters& p = parameters_;
  if (!p.counter_body_m) tau_body.head<3>() += mean_thrust_n_ * up_body;
  const Eigen::Vector3d lever_m = p.counter_body_m ? (p.position_body_m - *p.counter_body_m).eval() : p.position_body_m;
  tau_body.tail<3>() += mean_thrust_n_ * lever_m.cross(up_body);
}

double Thruster::submerged_fraction(double height_m, double axis_up) const {
  const double radius = 0.5 * parameters_.diameter_m;
  if (parameters_.ventilates) {
    const double loaded = std::max(1 - 0.769 * height_m / radius, 0.0);
    return std::clamp(1 - 0.675 * std::pow(loaded, 1.258), 0.0, 1.0);
  }
  if (height_m >= radius) return 1;
  const double half_height = radius * std::sqrt(std::max(0.0, 1 - axis_up * axis_up));
  if (height_m >= half_height) return 1;
  if (height_m <= -half_height) return 0;
  const double s = height_m / half_height;  // the wet part is a circular segment
  return 0.5 + (s * std::sqrt(1 - s * s) + std::asin(s)) / std::numbers::pi;
}

}  // namespace uwsim
