#include "uwsim/vehicle/thruster.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "uwsim/core/check.h"

namespace uwsim {

namespace {

// When the thrust is this close to its target, it is set to the target. An exponential never reaches its target: after
// 54 s at a lag of 75 ms, the difference is a subnormal number, which makes operations several times slower.
constexpr double kReachedN = 1e-30;

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
  require(spin == 1 || spin == -1, path + ".spin", spin, "must be 1 (right-handed) or -1 (left-handed)");
}

Thruster::Thruster(ThrusterParameters parameters) : parameters_(std::move(parameters)) {
  parameters_.check();
  const ThrusterParameters& p = parameters_;
  column_ << p.axis_body, p.position_body_m.cross(p.axis_body);
  column_with_torque_ = column_;
  column_with_torque_.tail<3>() -= p.spin * p.torque_per_thrust_m * p.axis_body;
  loss_ = p.diameter_m * std::sqrt(p.bollard_coefficient) / p.zero_thrust_advance_ratio;
}

void Thruster::set_command(double command) {
  command_ = command;
  target_n_ = parameters_.health * parameters_.curve.thrust_n(command);
}

void Thruster::advance(double step_s, bool powered) {
  if (step_s != step_s_) {
    const double steps = step_s / parameters_.time_constant_s;  // infinite if there is no lag
    step_s_ = step_s;
    decay_ = std::exp(-steps);
    mean_decay_ = -std::expm1(-steps) / steps;
  }
  const double target = powered ? target_n_ : 0;
  double difference = thrust_n_ - target;
  if (std::abs(difference) < kReachedN) difference = 0;
  mean_thrust_n_ = target + difference * mean_decay_;
  thrust_n_ = target + difference * decay_;
}

void Thruster::exchange_state(StateArchive& archive) {
  archive(command_);
  set_command(command_);
  archive(thrust_n_);
  archive(mean_thrust_n_);
}

void Thruster::add_wrench(const Vector6d& through_water, double density_kg_m3, double submerged,
                          Vector6d& tau_body) const {
  if (mean_thrust_n_ == 0) return;
  const double inflow_m_s = column_.dot(through_water);
  const double thrust = mean_thrust_n_ - loss_ * std::sqrt(density_kg_m3 * std::abs(mean_thrust_n_)) * inflow_m_s;
  tau_body += submerged * thrust * column_with_torque_;
}

double Thruster::submerged_fraction(double height_m, double axis_up) const {
  const double radius = 0.5 * parameters_.diameter_m;
  if (height_m >= radius) return 1;
  const double half_height = radius * std::sqrt(std::max(0.0, 1 - axis_up * axis_up));
  if (height_m >= half_height) return 1;
  if (height_m <= -half_height) return 0;
  const double s = height_m / half_height;  // the wet part is a circular segment
  return 0.5 + (s * std::sqrt(1 - s * s) + std::asin(s)) / std::numbers::pi;
}

}  // namespace uwsim
