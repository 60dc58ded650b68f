#pragma once

#include <span>
#include <vector>

#include "uwsim/core/water_field.h"

namespace uwsim {

/// The properties of the water at one depth.
struct WaterLevel {
  double depth_m = 0;
  double temperature_deg_c = 10;
  double salinity_psu = 0;
  double density_kg_m3 = 1000;
  double sound_speed_m_s = 0;  ///< 0: unspecified; computed from the other properties
};

/// Temperature, salinity, density and sound speed linear in depth between levels, constant above the first and below
/// the last.
class WaterProfile {
 public:
  /// Throws InvalidValue naming water.profile unless depths increase, every value is plausible for water, and the sound
  /// speed is specified at all levels or at none.
  explicit WaterProfile(std::span<const WaterLevel> levels);

  const std::vector<WaterLevel>& levels() const { return levels_; }
  /// Whether the density is the same at all depths.
  bool even() const { return even_; }
  WaterLevel at(double z_world_m) const;
  double density_at(double z_world_m) const;  ///< that of `at`
  DensityLayer density_layer_at(double z_world_m) const;
  /// From the layer above the first level to the one below the last.
  const std::vector<DensityLayer>& density_layers() const { return layers_; }
  /// Mass of the water between z and 0 per unit area: the integral of rho dz; negative above the surface [kg/m^2].
  double column_kg_m2(double z_world_m) const;

 private:
  void set_layers();
  std::size_t first_below(double depth_m) const;  // index of the first level deeper than this

  std::vector<WaterLevel> levels_;
  std::vector<DensityLayer> layers_;
  std::vector<double> columns_kg_m2_;  // from the surface to each level
  bool even_ = true;
};

}  // namespace uwsim
