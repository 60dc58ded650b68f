#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "uwsim/core/water_field.h"
#include "uwsim/world/current.h"
#include "uwsim/world/sound_speed.h"
#include "uwsim/world/space_time_grid.h"
#include "uwsim/world/tide.h"
#include "uwsim/world/water_profile.h"
#include "uwsim/world/waves.h"

namespace uwsim {

/// Temperature [deg C] and salinity [psu] by position and time.
using WaterMasses = SpaceTimeGrid<Eigen::Array2d>;

/// The water of a world. By default, it is calm and of uniform density, with one steady current; its temperature
/// changes linearly from the surface to `bottom_depth_m` and is constant below. Waves, currents and a profile may be
/// added. Copies are cheap: they share these parts, which are immutable.
///
/// Densities are those at atmospheric pressure. If the water is compressible, its pressure includes the effect of
/// compression by its own weight (EOS-80, sea_water.h): 2.2 m of head at 1000 m. Gravity grows with depth in it, by
/// another 0.1 m at 1000 m and 2.8 m at 5000 m; both or neither are on. Buoyancy has neither: hulls are assumed to
/// compress like the water around them, and their weight is that at the surface. Syntactic foam and thin pressure hulls
/// have about the bulk modulus of water; a rigid hull would gain 0.45 % of its displacement at 1000 m.
class Water : public EvenWater {
 public:
  double atmospheric_pressure_pa = 101325;
  double surface_temperature_deg_c = 15;
  double bottom_temperature_deg_c = 6;
  double bottom_depth_m = 40;
  double salinity_psu = 0;
  bool compressible = true;
  SoundSpeedEquation sound_speed_equation = SoundSpeedEquation::kUnesco;
  std::shared_ptr<const Waves> waves;           ///< null: a flat surface
  std::shared_ptr<const WaterProfile> profile;  ///< null: density_kg_m3, salinity_psu and the temperatures above apply
  std::vector<std::shared_ptr<const Current>> currents;  ///< added to current_world_m_s
  std::shared_ptr<const Tide> tide;                      ///< null: still water stands at z = 0
  /// Measured by instruments; null: the same at all places of one height. Density, pressure and sound follow the
  /// profile, which is the masses' column at one place and time.
  std::shared_ptr<const WaterMasses> masses;

  /// Throws InvalidValue naming the field.
  void check() const;

  static double depth_m(double z_world_m) { return -z_world_m; }
  /// Absolute pressure of still water: p_atm + the integral of rho g, both by depth; p_atm above the surface.
  double pressure_pa(double z_world_m) const;
  /// Absolute pressure under the waves at this time.
  double pressure_pa(const Eigen::Vector3d& point_world_m, double time_s) const;
  double temperature_deg_c(double z_world_m) const;
  double salinity_at_psu(double z_world_m) const;
  /// Those of the masses, if there are any.
  double temperature_deg_c(const Eigen::Vector3d& point_world_m, double time_s) const;
  double salinity_at_psu(const Eigen::Vector3d& point_world_m, double time_s) const;
  /// Speed of sound: from the profile, if it specifies one, else by the equation from temperature, salinity and
  /// pressure.
  double sound_speed_m_s(double z_world_m) const;
  /// Whether the profile specifies the speed of sound.
  bool gives_sound_speed() const;
  /// Selects the equation for the speed of sound by name; "automatic" selects the best for this water
  /// (best_sound_speed_equation). Throws InvalidValue if this water exceeds the range of the named equation, or if its
  /// profile specifies the speed of sound.
  void select_sound_speed_equation(std::string_view name);
  /// Extremes of temperature, salinity and depth between the surface and bottom_depth_m, or the profile's last level if
  /// that is deeper.
  WaterRange range() const;

  bool calm_and_even() const override { return !waves && !tide && (!profile || profile->even()); }
  double density_at(double z_world_m) const override;
  bool has_one_density() const override { return !profile || profile->even(); }
  DensityLayer density_layer_at(double z_world_m) const override;
  DensityLayer density_layer_below(const DensityLayer& layer) const override;
  /// Includes the tide.
  double wave_bound_m() const override { return (waves ? waves->bound_m() : 0) + (tide ? tide->bound_m() : 0); }
  bool surface_is_flat() const override { return !waves; }
  double still_level_m(double time_s) const override { return tide ? tide->height_m(time_s) : 0; }
  WaterSurface surface_over(const SurfaceArea& area, double time_s) const override;
  double surface_height_at(double x_world_m, double y_world_m, double time_s) const override;
  double gauge_pressure_at(const Eigen::Vector3d& point_world_m, double time_s) const override;
  double still_pressure_at(double z_world_m) const override;
  double pressure_head_at(const Eigen::Vector3d& point_world_m, double time_s) const override;
  WaterFlow flow_at(const Eigen::Vector3d& point_world_m, double time_s) const override;
  /// See Waves::add_main_flow.
  WaterFlow main_flow_at(const Eigen::Vector3d& point_world_m, double time_s, double emerged_m,
                         double* surface_m) const;
  VolumeFlow flow_over(const PlacedVolume& volume, double time_s) const override;
  std::optional<SteadyWater> steady() const override {
    if (waves || tide || !currents.empty()) return std::nullopt;
    return {{density_kg_m3, gravity_m_s2, current_world_m_s, profile.get()}};
  }
  bool flows_evenly() const override { return !waves && has_uniform_currents(); }
  bool flows_smoothly() const override;
  NearbyFlow flow_near(const PlacedVolume& volume, double time_s) const override;
  std::size_t division_of(const VolumeParts& parts, double centre_z_m) const override;
  VolumeLoad wave_load_on(const VolumePart& wet_world, const WaterSurface& surface, double time_s) const override;

 private:
  /// A position relative to the still surface, from which waves and profiles are measured.
  Eigen::Vector3d below_level(const Eigen::Vector3d& point_world_m, double time_s) const {
    return {point_world_m.x(), point_world_m.y(), point_world_m.z() - still_level_m(time_s)};
  }
  /// Adds to a pressure without compression and at the surface's gravity what both have by this depth.
  double column_pa(double still_pa, double depth_m) const;
  /// The currents alone, without waves.
  WaterFlow current_at(const Eigen::Vector3d& point_world_m, double time_s) const;
  NearbyFlow current_over(const PlacedVolume& volume, double time_s) const;
  bool has_uniform_currents() const;
};

}  // namespace uwsim
