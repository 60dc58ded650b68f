#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <limits>
#include <optional>

#include "uwsim/core/volume_parts.h"

namespace uwsim {

/// Motion of the water at a position and time, in the world frame.
struct WaterFlow {
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();  ///< current and waves combined
  /// Acceleration of the water's particles due to waves; the pressure on hulls includes the force that it causes
  Eigen::Vector3d wave_acceleration_m_s2 = Eigen::Vector3d::Zero();
  /// Local acceleration of the current; the pressure on hulls does not include the force that it causes
  Eigen::Vector3d current_acceleration_m_s2 = Eigen::Vector3d::Zero();
};

/// Motion of the water in a volume, expressed as that of a rigid body with the water's linear momentum and its angular
/// momentum about the volume's centroid, world frame. The accelerations follow from the rates of these momenta, so that
/// density times volume times wave_acceleration_m_s2 is the force of the waves' pressure on the volume (Froude-Krylov),
/// and the moment of inertia of the displaced water times the angular acceleration is its moment.
struct VolumeFlow : WaterFlow {
  Eigen::Vector3d angular_velocity_rad_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d wave_angular_acceleration_rad_s2 = Eigen::Vector3d::Zero();
};

/// The flow over a volume near a position and a time, to first order in both.
struct NearbyFlow {
  VolumeFlow flow;
  Eigen::Matrix3d gradient_1_s = Eigen::Matrix3d::Zero();  ///< of the current's velocity
  Eigen::Vector3d centroid_world_m = Eigen::Vector3d::Zero();
  double time_s = 0;

  VolumeFlow at(const Eigen::Vector3d& other_centroid_world_m, double other_time_s) const {
    VolumeFlow moved = flow;
    moved.velocity_m_s += gradient_1_s * (other_centroid_world_m - centroid_world_m) +
                          (other_time_s - time_s) * flow.current_acceleration_m_s2;
    return moved;
  }
};

/// A layer in which density is linear in height: rho(z) = density_kg_m3 + gradient_kg_m4 (z - reference_m).
struct DensityLayer {
  double low_m = -std::numeric_limits<double>::infinity();
  double high_m = std::numeric_limits<double>::infinity();
  double reference_m = 0;
  double density_kg_m3 = 1000;
  double gradient_kg_m4 = 0;
  std::size_t number = 0;  ///< from the surface down

  double at(double z_world_m) const { return density_kg_m3 + gradient_kg_m4 * (z_world_m - reference_m); }
};

/// The surface over an area: conservative bounds of its height [m], and the plane that has its mean height and slopes.
struct WaterSurface {
  double low_m = 0, high_m = 0;
  double mean_m = 0;  ///< height of the plane at the area's middle
  double slope_x = 0, slope_y = 0;
};

/// An area of the surface: everything within `radius_m` of its middle. The mean is taken over a part of the area;
/// `spread_m2` is that part's second moment per unit area about the middle: xx, xy, yy.
struct SurfaceArea {
  double x_world_m = 0, y_world_m = 0, radius_m = 0;
  std::array<double, 3> spread_m2{};
};

/// Force [N] and moment about a volume's centroid [N m] per unit density [kg/m^3], world frame.
struct VolumeLoad {
  Eigen::Vector3d force_m4_s2 = Eigen::Vector3d::Zero();
  Eigen::Vector3d moment_m5_s2 = Eigen::Vector3d::Zero();
};

/// Water that does not change. Two that are equal load a body at rest equally.
struct SteadyWater {
  double density_kg_m3 = 0, gravity_m_s2 = 0;
  Eigen::Vector3d current_world_m_s = Eigen::Vector3d::Zero();
  const void* profile = nullptr;

  bool operator==(const SteadyWater&) const = default;
};

/// The interface between the water and the force models: density, pressure, surface and motion at a position (world
/// ENU, mean surface at z = 0) and time. Every function is pure and allocates nothing.
class WaterField {
 public:
  virtual ~WaterField() = default;

  /// Whether the surface is flat at z = 0 and the density uniform, so that closed forms apply.
  virtual bool calm_and_even() const = 0;
  virtual double gravity() const = 0;                     ///< [m/s^2]
  virtual double density_at(double z_world_m) const = 0;  ///< of still water [kg/m^3]
  virtual bool has_one_density() const = 0;               ///< whether still water has the same density at all depths
  virtual DensityLayer density_layer_at(double z_world_m) const = 0;
  /// The next deeper layer, which must exist.
  virtual DensityLayer density_layer_below(const DensityLayer& layer) const = 0;
  /// Conservative bound on the surface's distance from z = 0 [m]; 0 if the surface is flat and stands there.
  virtual double wave_bound_m() const = 0;
  /// Everything below low_m is wet, everything above high_m is dry.
  virtual WaterSurface surface_over(const SurfaceArea& area, double time_s) const = 0;
  virtual double surface_height_at(double x_world_m, double y_world_m, double time_s) const = 0;  ///< [m]
  /// Pressure above atmospheric; 0 above the surface [Pa].
  virtual double gauge_pressure_at(const Eigen::Vector3d& point_world_m, double time_s) const = 0;
  /// The gauge pressure of still water [Pa] that acts on hulls: the integral of rho g from z up to the surface at z =
  /// 0, without the effect of the water's compression. Negative above the surface.
  virtual double still_pressure_at(double z_world_m) const = 0;
  /// Pressure head at a point: the height of still water [m] that exerts the same pressure, such that the gauge
  /// pressure is still_pressure_at(-head). Above the surface, it is minus the height above the surface.
  virtual double pressure_head_at(const Eigen::Vector3d& point_world_m, double time_s) const = 0;
  virtual WaterFlow flow_at(const Eigen::Vector3d& point_world_m, double time_s) const = 0;
  /// The flow averaged over a volume, which may be as long as a wave.
  virtual VolumeFlow flow_over(const PlacedVolume& volume, double time_s) const = 0;
  /// The index of the division of a volume whose slices are short compared with the waves.
  virtual std::size_t division_of(const VolumeParts& parts, double centre_z_m) const = 0;
  /// The load on a volume below the surface due to the gradient of the waves' pressure, world frame.
  virtual VolumeLoad wave_load_on(const VolumePart& wet_world, const WaterSurface& surface, double time_s) const = 0;
  /// Returns true if the surface is flat, at `still_level_m`.
  virtual bool surface_is_flat() const = 0;
  /// Height of the water's surface without waves [m].
  virtual double still_level_m(double time_s) const = 0;
  /// All that moves a body at rest, if it is the same at all times; empty if it may change.
  virtual std::optional<SteadyWater> steady() const { return std::nullopt; }
  /// Returns true if the flow is the same at all places.
  virtual bool flows_evenly() const { return false; }
  /// Returns true if the flow varies in space, and so little over a step that `flow_near` suffices for it.
  virtual bool flows_smoothly() const { return false; }
  virtual NearbyFlow flow_near(const PlacedVolume& volume, double time_s) const {
    return {.flow = flow_over(volume, time_s), .centroid_world_m = volume.centroid_world_m, .time_s = time_s};
  }
};

/// Water of uniform density with a flat surface at z = 0 and one steady, uniform current.
class EvenWater : public WaterField {
 public:
  double density_kg_m3 = 1000;
  double gravity_m_s2 = 9.80665;  ///< standard gravity (CGPM 1901)
  Eigen::Vector3d current_world_m_s = Eigen::Vector3d::Zero();

  bool calm_and_even() const override { return true; }
  double gravity() const override { return gravity_m_s2; }
  double density_at(double) const override { return density_kg_m3; }
  bool has_one_density() const override { return true; }
  DensityLayer density_layer_at(double) const override { return {.density_kg_m3 = density_kg_m3}; }
  DensityLayer density_layer_below(const DensityLayer& layer) const override { return layer; }
  double wave_bound_m() const override { return 0; }
  bool surface_is_flat() const override { return true; }
  double still_level_m(double) const override { return 0; }
  std::optional<SteadyWater> steady() const override { return {{density_kg_m3, gravity_m_s2, current_world_m_s}}; }
  bool flows_evenly() const override { return true; }
  WaterSurface surface_over(const SurfaceArea&, double) const override { return {}; }
  double surface_height_at(double, double, double) const override { return 0; }
  double gauge_pressure_at(const Eigen::Vector3d& point_world_m, double) const override {
    return point_world_m.z() < 0 ? still_pressure_at(point_world_m.z()) : 0;
  }
  double still_pressure_at(double z_world_m) const override { return -density_kg_m3 * gravity_m_s2 * z_world_m; }
  double pressure_head_at(const Eigen::Vector3d& point_world_m, double) const override { return -point_world_m.z(); }
  WaterFlow flow_at(const Eigen::Vector3d&, double) const override { return {.velocity_m_s = current_world_m_s}; }
  VolumeFlow flow_over(const PlacedVolume&, double) const override { return {{.velocity_m_s = current_world_m_s}}; }
  std::size_t division_of(const VolumeParts&, double) const override { return 0; }
  VolumeLoad wave_load_on(const VolumePart&, const WaterSurface&, double) const override { return {}; }
};

}  // namespace uwsim
