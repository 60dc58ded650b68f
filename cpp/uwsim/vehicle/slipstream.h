#pragma once

#include <Eigen/Core>

namespace uwsim {

/// The jet behind a propeller that pushes its vehicle along its axis, at one distance.
///
/// By axial momentum theory, as for a ship's rudder (Yasukawa and Yoshimura 2015, "Introduction of MMG standard method
/// for ship maneuvering predictions", J. Mar. Sci. Technol. 20:37, eq. 35 ff.): a thrust T on a disc of area A that
/// moves at u_a through the water makes the water faster at the disc by
///
///   u_i = (sqrt(u_a^2 + 2 T / (rho A)) - u_a) / 2,
///
/// and by u_i (1 + x / sqrt(x^2 + R^2)) at a distance x behind it, as a cylinder of vortices of the radius R has it
/// (McCormick 1967, "Aerodynamics of V/STOL Flight", ch. 4, from memory), twice as much far behind. The jet contracts
/// by continuity. No swirl, no mixing with the water around it; a propeller that pulls backward makes no jet here.
struct Slipstream {
  Eigen::Vector3d velocity_body_m_s = Eigen::Vector3d::Zero();  ///< of the parts in it relative to water at rest, more
  Eigen::Vector3d axis_body = Eigen::Vector3d::UnitX();         ///< unit
  Eigen::Vector3d hub_body_m = Eigen::Vector3d::Zero();
  double radius_m = 0;  ///< 0: none

  /// `inflow_m_s`: u_a. `place_body_m`: a point at the distance in question.
  static Slipstream behind(double thrust_n, double inflow_m_s, double density_kg_m3, double disc_radius_m,
                           const Eigen::Vector3d& hub_body_m, const Eigen::Vector3d& axis_body,
                           const Eigen::Vector3d& place_body_m);
  /// The share of a line of this length, along the unit `span_body` and with its middle there, that is in the jet.
  double share_of(const Eigen::Vector3d& middle_body_m, const Eigen::Vector3d& span_body, double length_m) const;
};

}  // namespace uwsim
