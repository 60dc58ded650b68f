#pragma once

#include <memory>
#include <vector>

#include "uwsim/core/water_field.h"
#include "uwsim/world/current.h"
#include "uwsim/world/water_profile.h"
#include "uwsim/world/waves.h"

namespace uwsim {

/// The water of a world. By default it is calm, of uniform density, with one steady current, and its temperature
/// changes linearly from the surface to `bottom_depth_m` and is constant below. Waves, currents and a profile may be
/// added. Copies are cheap: they share these, which never change.
class Water : public EvenWater {
 public:
  double atmospheric_pressure_pa = 101325;
  double surface_temperature_deg_c = 15;
  double bottom_temperature_deg_c = 6;
  double bottom_depth_m = 40;
  double salinity_psu = 0;
  std::shared_ptr<const Waves> waves;           ///< null: a flat surface
  std::shared_ptr<const WaterProfile> profile;  ///< null: density_kg_m3, salinity_psu and the temperatures above
  std::vector<std::shared_ptr<const Current>> currents;  ///< added to current_world_m_s

  /// Throws InvalidValue that names the field.
  void check() const;

  static double depth_m(double z_world_m) { return -z_world_m; }
  /// Absolute pressure of still water: p_atm + the integral of rho g; p_atm above the surface.
  double pressure_pa(double z_world_m) const;
  /// Absolute pressure under the waves of the moment.
  double pressure_pa(const Eigen::Vector3d& point_world_m, double time_s) const;
  double temperature_deg_c(double z_world_m) const;
  double salinity_at_psu(double z_world_m) const;
  /// The profile's sound speed; 0 where none is given: it then follows from temperature, salinity and depth.
  double given_sound_speed_m_s(double z_world_m) const;

  bool calm_and_even() const override { return !waves && (!profile || profile->even()); }
  double density_at(double z_world_m) const override;
  DensityLayer density_layer_at(double z_world_m) const override;
  double wave_bound_m() const override { return waves ? waves->bound_m() : 0; }
  SurfaceSpan surface_span_at(double x_world_m, double y_world_m, double radius_m, double time_s) const override;
  double surface_height_at(double x_world_m, double y_world_m, double time_s) const override;
  double gauge_pressure_at(const Eigen::Vector3d& point_world_m, double time_s) const override;
  double still_pressure_at(double z_world_m) const override;
  void pressure_heads(std::span<const Eigen::Vector3d> points_world_m, double time_s,
                      std::span<double> heads_m) const override;
  WaveLoad wave_load(const Eigen::Vector3d& centroid_world_m, double volume_m3, const Eigen::Matrix3d& second_moment_m5,
                     double time_s) const override;
  WaterFlow flow_at(const Eigen::Vector3d& point_world_m, double time_s) const override;
};

}  // namespace uwsim
