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
  double sum_m_s = current_world_m_s.norm();
  for (const auto& current : currents) sum_m_s += current->bound_m_s();
  require(sum_m_s <= 10, "water.current", sum_m_s,
          "m/s, the sum of all currents' largest speeds (gusts: three standard deviations): must be at most 10 m/s");
}

double Water::pressure_pa(double z_world_m) const {
  return atmospheric_pressure_pa + std::max(0.0, still_pressure_at(z_world_m));
}

double Water::pressure_pa(const Eigen::Vector3d& point_world_m, double time_s) const {
  return atmospheric_pressure_pa + gauge_pressure_at(point_world_m, time_s);
}

double Water::temperature_deg_c(double z_world_m) const {
  if (profile) return profile->at(z_world_m).temperature_deg_c;
  const double fraction = std::clamp(depth_m(z_world_m) / bottom_depth_m, 0.0, 1.0);
  return surface_temperature_deg_c + fraction * (bottom_temperature_deg_c - surface_temperature_deg_c);
}

double Water::salinity_at_psu(double z_world_m) const {
  return profile ? profile->at(z_world_m).salinity_psu : salinity_psu;
}

double Water::given_sound_speed_m_s(double z_world_m) const {
  return profile ? profile->at(z_world_m).sound_speed_m_s : 0;
}

double Water::density_at(double z_world_m) const {
  return profile ? profile->at(z_world_m).density_kg_m3 : density_kg_m3;
}

DensityLayer Water::density_layer_at(double z_world_m) const {
  if (!profile) return {.density_kg_m3 = density_kg_m3};
  return profile->density_layer_at(z_world_m);
}

SurfaceSpan Water::surface_span_at(double x, double y, double radius_m, double time_s) const {
  return waves ? waves->span_at(x, y, radius_m, time_s) : SurfaceSpan{};
}

double Water::surface_height_at(double x, double y, double time_s) const {
  return waves ? waves->height_at(x, y, time_s) : 0;
}

double Water::gauge_pressure_at(const Eigen::Vector3d& point_world_m, double time_s) const {
  const double head_m = waves ? waves->head_at(point_world_m, time_s) : -point_world_m.z();
  return std::max(0.0, still_pressure_at(-head_m));
}

double Water::still_pressure_at(double z_world_m) const {
  return gravity_m_s2 * (profile ? profile->column_kg_m2(z_world_m) : -density_kg_m3 * z_world_m);
}

void Water::pressure_heads(std::span<const Eigen::Vector3d> points_world_m, double time_s,
                           std::span<double> heads_m) const {
  if (waves) return waves->heads(points_world_m, time_s, heads_m);
  EvenWater::pressure_heads(points_world_m, time_s, heads_m);
}

WaveLoad Water::wave_load(const Eigen::Vector3d& centroid_world_m, double volume_m3,
                          const Eigen::Matrix3d& second_moment_m5, double time_s) const {
  return waves ? waves->load(centroid_world_m, volume_m3, second_moment_m5, time_s) : WaveLoad{};
}

WaterFlow Water::flow_at(const Eigen::Vector3d& point_world_m, double time_s) const {
  WaterFlow flow{.velocity_m_s = current_world_m_s};
  for (const auto& current : currents) {
    const CurrentSample sample = current->at(point_world_m, time_s);
    flow.velocity_m_s += sample.velocity_m_s;
    flow.current_acceleration_m_s2 += sample.rate_m_s2;
  }
  if (waves) waves->add_flow(point_world_m, time_s, flow);
  return flow;
}

}  // namespace uwsim
