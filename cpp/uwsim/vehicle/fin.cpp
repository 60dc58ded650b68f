#include "uwsim/vehicle/fin.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "uwsim/core/check.h"

namespace uwsim {

void FinParameters::check() const {
  const std::string path = "fins." + name;
  const auto require_positive = [&](double value, const char* field) {
    require(std::isfinite(value) && value > 0, path + field, value, "must be positive");
  };
  require(position_body_m.allFinite(), path + ".position_m", position_body_m.transpose(), "must be finite");
  require(std::abs(span_body.norm() - 1) < 1e-6 && std::abs(span_body.x()) < 1e-6, path + ".span",
          span_body.transpose(), "must be a unit vector perpendicular to x");
  require_positive(area_m2, ".area_m2");
  require_positive(aspect_ratio, ".aspect_ratio");
  require_positive(efficiency, ".efficiency");
  require_positive(stall_angle_rad, ".stall_angle_deg");
  require_positive(stall_sharpness_rad, ".stall_sharpness_deg");
  require_positive(rate_max_rad_s, ".rate_max_deg_s");
  require(std::isfinite(parasitic_drag) && parasitic_drag >= 0, path + ".parasitic_drag", parasitic_drag,
          "must be 0 or more");
  require(deflection_max_rad >= 0 && deflection_max_rad <= std::numbers::pi / 2, path + ".deflection_max_deg",
          deflection_max_rad, "must be in [0, pi/2] rad");
}

double FinParameters::lift_slope() const {
  return std::numbers::pi * aspect_ratio / (1 + std::sqrt(1 + aspect_ratio * aspect_ratio / 4));
}

Fin::Fin(FinParameters parameters) : parameters_(std::move(parameters)) {
  parameters_.check();
  lift_slope_ = parameters_.lift_slope();
  induced_drag_ = 1 / (std::numbers::pi * parameters_.efficiency * parameters_.aspect_ratio);
  half_span_m_ = 0.5 * std::sqrt(parameters_.area_m2 * parameters_.aspect_ratio);
}

Vector6d Fin::column() const {
  const Eigen::Vector3d force =
      -lift_slope_ * parameters_.area_m2 * Eigen::Vector3d::UnitX().cross(parameters_.span_body);
  Vector6d column;
  column << force, parameters_.position_body_m.cross(force);
  return column;
}

void Fin::advance(double step_s) {
  const double turn_max_rad = parameters_.rate_max_rad_s * step_s;
  angle_rad_ += std::clamp(command_rad_ - angle_rad_, -turn_max_rad, turn_max_rad);
}

void Fin::exchange_state(StateArchive& archive) {
  archive(command_rad_);
  archive(angle_rad_);
}

Fin::Coefficients Fin::coefficients(double attack_rad) const {
  const double s = std::sin(attack_rad), c = std::cos(attack_rad);
  Coefficients attached{.lift = lift_slope_ * s * c};
  attached.drag = parameters_.parasitic_drag + induced_drag_ * attached.lift * attached.lift;
  if (!parameters_.stalls) return attached;
  // In flow from behind, stall depends on the angle between the chord line and the flow.
  const double angle = std::asin(std::min(1.0, std::abs(s)));
  const double stalled = 1 / (1 + std::exp((parameters_.stall_angle_rad - angle) / parameters_.stall_sharpness_rad));
  const double plate_lift = 2 * s * std::abs(s) * c, plate_drag = parameters_.parasitic_drag + 2 * std::abs(s * s * s);
  return {attached.lift + stalled * (plate_lift - attached.lift),
          attached.drag + stalled * (plate_drag - attached.drag)};
}

void Fin::add_wrench(const Vector6d& through_water, double density_kg_m3, double submerged, Vector6d& tau_body) const {
  const Eigen::Vector3d velocity = through_water.head<3>() + through_water.tail<3>().cross(parameters_.position_body_m);
  add_force(velocity, density_kg_m3, submerged, tau_body);
}

void Fin::add_wrench(const Vector6d& through_water, double density_kg_m3, double submerged, const Slipstream& jet,
                     Vector6d& tau_body) const {
  const Eigen::Vector3d velocity = through_water.head<3>() + through_water.tail<3>().cross(parameters_.position_body_m);
  const double inside = jet.share_of(parameters_.position_body_m, parameters_.span_body, 2 * half_span_m_);
  add_force(velocity, density_kg_m3, (1 - inside) * submerged, tau_body);
  add_force(velocity + jet.velocity_body_m_s, density_kg_m3, inside * submerged, tau_body);
}

void Fin::add_force(const Eigen::Vector3d& velocity, double density_kg_m3, double submerged, Vector6d& tau_body) const {
  const Eigen::Vector3d& span = parameters_.span_body;
  const Eigen::Vector3d across = velocity - velocity.dot(span) * span;
  const double speed = across.norm();
  if (speed < 1e-9) return;
  const Eigen::Vector3d direction = across / speed, lift_direction = direction.cross(span);
  const Eigen::Vector3d ahead = Eigen::Vector3d::UnitX();
  // The angle of the flow to the hull's axis; the angle of attack is this angle minus the deflection, which turns the
  // chord.
  const double drift = std::atan2(-direction.dot(ahead.cross(span)), direction.dot(ahead));
  const Coefficients c = coefficients(drift - angle_rad_);
  const double pressure_area = 0.5 * density_kg_m3 * speed * speed * parameters_.area_m2 * submerged;
  const Eigen::Vector3d force = pressure_area * (c.lift * lift_direction - c.drag * direction);
  tau_body.head<3>() += force;
  tau_body.tail<3>() += parameters_.position_body_m.cross(force);
}

double Fin::submerged_fraction(double height_m, double span_up) const {
  const double half_height = half_span_m_ * std::abs(span_up);
  if (height_m >= half_height) return 1;
  if (height_m <= -half_height) return 0;
  return 0.5 * (1 + height_m / half_height);
}

}  // namespace uwsim
