#pragma once

#include <Eigen/Core>

namespace uwsim {

/// Still water, surface at z = 0. Temperature falls linearly from the surface to `bottom_depth_m` and is constant
/// below.
struct Water {
  double density_kg_m3 = 1000;
  double gravity_m_s2 = 9.80665;  ///< standard gravity (CGPM 1901)
  double atmospheric_pressure_pa = 101325;
  double surface_temperature_deg_c = 15;
  double bottom_temperature_deg_c = 6;
  double bottom_depth_m = 40;
  double salinity_psu = 0;
  Eigen::Vector3d current_world_m_s = Eigen::Vector3d::Zero();

  /// Throws InvalidValue that names the field.
  void check() const;

  static double depth_m(double z_world_m) { return -z_world_m; }
  /// Absolute pressure p = p_atm + rho g d under water, p_atm above it.
  double pressure_pa(double z_world_m) const;
  double temperature_deg_c(double z_world_m) const;
};

}  // namespace uwsim
