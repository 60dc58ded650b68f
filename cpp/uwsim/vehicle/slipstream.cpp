#include "uwsim/vehicle/slipstream.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace uwsim {

Slipstream Slipstream::behind(double thrust_n, double inflow_m_s, double density_kg_m3, double disc_radius_m,
                              const Eigen::Vector3d& hub_body_m, const Eigen::Vector3d& axis_body,
                              const Eigen::Vector3d& place_body_m) {
  Slipstream jet{.axis_body = axis_body, .hub_body_m = hub_body_m};
  if (thrust_n <= 0) return jet;
  const double area_m2 = std::numbers::pi * disc_radius_m * disc_radius_m;
  const double whole = std::sqrt(inflow_m_s * inflow_m_s + 2 * thrust_n / (density_kg_m3 * area_m2));
  const double at_disc = 0.5 * (whole - inflow_m_s);
  const double behind_m = (hub_body_m - place_body_m).dot(axis_body);
  const double faster = at_disc * (1 + behind_m / std::hypot(behind_m, disc_radius_m));
  jet.velocity_body_m_s = faster * axis_body;
  jet.radius_m = disc_radius_m * std::sqrt(std::max(inflow_m_s + at_disc, 0.0) / std::max(inflow_m_s + faster, 1e-9));
  return jet;
}

double Slipstream::share_of(const Eigen::Vector3d& middle_body_m, const Eigen::Vector3d& span_body,
                            double length_m) const {
  const Eigen::Vector3d offset = middle_body_m - hub_body_m;
  const Eigen::Vector3d across = offset - offset.dot(axis_body) * axis_body;
  const double along = across.dot(span_body), aside = (across - along * span_body).norm();
  if (aside >= radius_m) return 0;
  const double half = 0.5 * length_m, chord = std::sqrt(radius_m * radius_m - aside * aside);
  return std::max(0.0, std::min(along + half, chord) - std::max(along - half, -chord)) / length_m;
}

}  // namespace uwsim
