#include "uwsim/world/water.h"

#include <algorithm>
#include <cmath>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

void require_in(double value, double low, double high, const char* path, const char* rule) {
  require(value >= low && value <= high, path, value, rule);
}

}  // namespace

void Water::check() const {
  require_in(density_kg_m3, 900, 1300, "water.density_kg_m3", "must be in [900, 1300] kg/m3");
  require_in(gravity_m_s2, 0, 30, "water.gravity_m_s2", "must be in [0, 30] m/s2");
  require_in(atmospheric_pressure_pa, 0, 2e5, "water.atmospheric_pressure_pa", "must be in [0, 200000] Pa");
  require_in(surface_temperature_deg_c, -2, 40, "water.surface_temperature_deg_c", "must be in [-2, 40] deg C");
  require_in(bottom_temperature_deg_c, -2, 40, "water.bottom_temperature_deg_c", "must be in [-2, 40] deg C");
  require_in(bottom_depth_m, 1e-3, 12000, "water.bottom_depth_m", "must be in [0.001, 12000] m");
  require_in(salinity_psu, 0, 45, "water.salinity_psu", "must be in [0, 45]");
  require(current_world_m_s.allFinite() && current_world_m_s.norm() <= 10, "water.current_world_m_s",
          current_world_m_s.transpose(), "must be at most 10 m/s");
}

double Water::pressure_pa(double z_world_m) const {
  return atmospheric_pressure_pa + density_kg_m3 * gravity_m_s2 * std::max(0.0, depth_m(z_world_m));
}

double Water::temperature_deg_c(double z_world_m) const {
  const double fraction = std::clamp(depth_m(z_world_m) / bottom_depth_m, 0.0, 1.0);
  return surface_temperature_deg_c + fraction * (bottom_temperature_deg_c - surface_temperature_deg_c);
}

}  // namespace uwsim
