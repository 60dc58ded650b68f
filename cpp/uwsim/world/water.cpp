#include "uwsim/world/water.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "uwsim/core/check.h"
#include "uwsim/core/with_unit.h"
#include "uwsim/world/sea_water.h"

namespace uwsim {
namespace {

constexpr double kDeepest_m = 12000;  // deeper than any ocean
constexpr double kDeepest_pa = 1.5e8;
constexpr double kGravityGrowth_1_m = 2.26e-7;  // of g with depth in the sea (IOC, SCOR and IAPSO 2010, TEOS-10)

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
  require(sum_m_s <= 10, "water.current", with_unit(sum_m_s, "m/s, the sum of all currents' largest speeds"),
          "must be at most 10 m/s, with three standard deviations of gusts");
}

double Water::pressure_pa(double z_world_m) const {
  return atmospheric_pressure_pa + column_pa(std::max(0.0, still_pressure_at(z_world_m)), depth_m(z_world_m));
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

double Water::temperature_deg_c(const Eigen::Vector3d& point_world_m, double time_s) const {
  return masses ? masses->at(point_world_m, time_s)(0) : temperature_deg_c(point_world_m.z());
}

double Water::salinity_at_psu(const Eigen::Vector3d& point_world_m, double time_s) const {
  return masses ? masses->at(point_world_m, time_s)(1) : salinity_at_psu(point_world_m.z());
}

bool Water::gives_sound_speed() const { return profile && profile->levels().front().sound_speed_m_s > 0; }

double Water::sound_speed_m_s(double z_world_m) const {
  if (gives_sound_speed()) return profile->at(z_world_m).sound_speed_m_s;
  const double depth = std::clamp(depth_m(z_world_m), 0.0, kDeepest_m);
  const double gauge_pa = column_pa(still_pressure_at(-depth), depth);
  return uwsim::sound_speed_m_s(sound_speed_equation, temperature_deg_c(-depth), salinity_at_psu(-depth), depth,
                                gauge_pa);
}

void Water::select_sound_speed_equation(std::string_view name) {
  if (name == kAutomaticSoundSpeed) {
    sound_speed_equation = best_sound_speed_equation(range());
    return;
  }
  const SoundSpeedEquation named = uwsim::sound_speed_equation(name);
  require(!gives_sound_speed(), "water.sound_speed_equation", name,
          "must not be given beside a profile that gives sound_speed_m_s");
  require(valid_range(named).covers(range()), "water.sound_speed_equation", name,
          "is valid for " + valid_range(named).text() + "; this water has " + range().text());
  sound_speed_equation = named;
}

WaterRange Water::range() const {
  if (!profile) {
    const auto [cold, warm] = std::minmax(surface_temperature_deg_c, bottom_temperature_deg_c);
    return {cold, warm, salinity_psu, salinity_psu, bottom_depth_m};
  }
  const WaterLevel& top = profile->levels().front();
  WaterRange all{top.temperature_deg_c, top.temperature_deg_c, top.salinity_psu, top.salinity_psu, bottom_depth_m};
  for (const WaterLevel& level : profile->levels()) {
    all.coldest_deg_c = std::min(all.coldest_deg_c, level.temperature_deg_c);
    all.warmest_deg_c = std::max(all.warmest_deg_c, level.temperature_deg_c);
    all.freshest_psu = std::min(all.freshest_psu, level.salinity_psu);
    all.saltiest_psu = std::max(all.saltiest_psu, level.salinity_psu);
    all.deepest_m = std::max(all.deepest_m, level.depth_m);
  }
  return all;
}

double Water::density_at(double z_world_m) const { return profile ? profile->density_at(z_world_m) : density_kg_m3; }

DensityLayer Water::density_layer_at(double z_world_m) const {
  if (!profile) return {.density_kg_m3 = density_kg_m3};
  return profile->density_layer_at(z_world_m);
}

DensityLayer Water::density_layer_below(const DensityLayer& layer) const {
  return profile ? profile->density_layers()[layer.number + 1] : layer;
}

WaterSurface Water::surface_over(const SurfaceArea& area, double time_s) const {
  WaterSurface surface = waves ? waves->surface_over(area, time_s) : WaterSurface{};
  if (!tide) return surface;
  const double level = still_level_m(time_s);
  surface.low_m += level;
  surface.high_m += level;
  surface.mean_m += level;
  return surface;
}

double Water::surface_height_at(double x, double y, double time_s) const {
  return (waves ? waves->height_at(x, y, time_s) : 0) + still_level_m(time_s);
}

double Water::gauge_pressure_at(const Eigen::Vector3d& point_world_m, double time_s) const {
  const Eigen::Vector3d point = below_level(point_world_m, time_s);
  const double head_m = waves ? waves->head_at(point, time_s) + waves->bernoulli_head_at(point, time_s) : -point.z();
  return column_pa(std::max(0.0, still_pressure_at(-head_m)), head_m);
}

/// Uses temperature and salinity as specified in sea_water.h. Below kDeepest_pa, the compression is constant.
double Water::column_pa(double still_pa, double depth_m) const {
  if (!compressible || !(still_pa > 0)) return still_pa;
  still_pa *= 1 + 0.5 * kGravityGrowth_1_m * depth_m;
  const double z = -2.0 / 3 * depth_m, squeezed_pa = std::min(still_pa, kDeepest_pa);
  return still_pa - squeezed_pa + compressed_pressure_pa(squeezed_pa, temperature_deg_c(z), salinity_at_psu(z));
}

double Water::still_pressure_at(double z_world_m) const {
  return gravity_m_s2 * (profile ? profile->column_kg_m2(z_world_m) : -density_kg_m3 * z_world_m);
}

double Water::pressure_head_at(const Eigen::Vector3d& point_world_m, double time_s) const {
  const Eigen::Vector3d point = below_level(point_world_m, time_s);
  return waves ? waves->head_at(point, time_s) : -point.z();
}

WaterFlow Water::current_at(const Eigen::Vector3d& point_world_m, double time_s) const {
  WaterFlow flow{.velocity_m_s = current_world_m_s};
  for (const auto& current : currents) {
    const CurrentSample sample = current->at(point_world_m, time_s);
    flow.velocity_m_s += sample.velocity_m_s;
    flow.current_acceleration_m_s2 += sample.rate_m_s2;
  }
  return flow;
}

bool Water::has_uniform_currents() const {
  return std::ranges::all_of(currents, [](const auto& current) { return current->is_uniform(); });
}

/// A current that varies is taken at six points, whose second moment is the volume's: exact where it is linear.
NearbyFlow Water::current_over(const PlacedVolume& volume, double time_s) const {
  const Eigen::Vector3d& middle = volume.centroid_world_m;
  NearbyFlow near{
      .flow = {{.velocity_m_s = current_world_m_s}}, .centroid_world_m = volume.centroid_world_m, .time_s = time_s};
  Eigen::Vector3d turning = Eigen::Vector3d::Zero();
  const Eigen::Matrix3d arms = volume.world_from_body * volume.parts.spread_m;
  for (const auto& current : currents) {
    const CurrentOver mean = current->over(middle, arms, time_s);
    near.flow.velocity_m_s += mean.velocity_m_s;
    near.flow.current_acceleration_m_s2 += mean.rate_m_s2;
    near.gradient_1_s += mean.gradient_1_s;
    turning += volume.parts.whole().volume_m3 * mean.turning_m2_s;
  }
  near.flow.angular_velocity_rad_s =
      volume.world_from_body * (volume.parts.inverse_inertia_1_m5 * (volume.world_from_body.transpose() * turning));
  return near;
}

VolumeFlow Water::flow_over(const PlacedVolume& volume, double time_s) const {
  VolumeFlow flow = has_uniform_currents() ? VolumeFlow{current_at(volume.centroid_world_m, time_s)}
                                           : current_over(volume, time_s).flow;
  if (waves) {
    const Eigen::Vector3d centroid = below_level(volume.centroid_world_m, time_s);
    waves->add_flow_over({volume.parts, centroid, volume.world_from_body}, time_s, flow);
  }
  return flow;
}

bool Water::flows_smoothly() const {
  return !waves && !has_uniform_currents() &&
         std::ranges::all_of(currents, [](const auto& current) { return current->is_smooth(); });
}

NearbyFlow Water::flow_near(const PlacedVolume& volume, double time_s) const {
  return flows_smoothly() ? current_over(volume, time_s) : WaterField::flow_near(volume, time_s);
}

std::size_t Water::division_of(const VolumeParts& parts, double centre_z_m) const {
  return waves ? waves->division_of(parts, centre_z_m) : 0;
}

VolumeLoad Water::wave_load_on(const VolumePart& wet_world, const WaterSurface& surface, double time_s) const {
  if (!waves) return {};
  VolumePart wet = wet_world;
  wet.centroid_m = below_level(wet.centroid_m, time_s);
  return waves->load_on(wet, surface, time_s);
}

WaterFlow Water::flow_at(const Eigen::Vector3d& point_world_m, double time_s) const {
  WaterFlow flow = current_at(point_world_m, time_s);
  if (waves) waves->add_flow(below_level(point_world_m, time_s), time_s, flow);
  return flow;
}

WaterFlow Water::main_flow_at(const Eigen::Vector3d& point_world_m, double time_s, double emerged_m,
                              double* surface_m) const {
  WaterFlow flow = current_at(point_world_m, time_s);
  if (surface_m != nullptr) *surface_m = 0;
  if (waves) waves->add_main_flow(below_level(point_world_m, time_s), time_s, flow, emerged_m, surface_m);
  if (surface_m != nullptr) *surface_m += still_level_m(time_s);
  return flow;
}

}  // namespace uwsim
