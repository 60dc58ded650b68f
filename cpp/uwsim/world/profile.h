#pragma once

#include <span>
#include <vector>

#include "uwsim/core/water_field.h"

namespace uwsim {

/// Water at a depth.
struct WaterLevel {
  double depth_m = 0;
  double temperature_deg_c = 10;
  double salinity_psu = 0;
  double density_kg_m3 = 1000;
  double sound_speed_m_s = 0;  ///< 0: not given; then by temperature, salinity and depth
};

/// Temperature, salinity, density and sound speed linear in depth between levels, constant above the first and below
/// the last.
class WaterProfile {
 public:
  /// Throws InvalidValue, naming water.profile, unless depths rise, figures are of water, and sound speed is given at
  /// all levels or at none.
  explicit WaterProfile(std::span<const WaterLevel> levels);

  const std::vector<WaterLevel>& levels() const { return levels_; }
  /// One density from top to bottom.
  bool even() const { return even_; }
  WaterLevel at(double z_world_m) const;
  DensityLayer density_layer_at(double z_world_m) const;
  /// Mass over a square metre of the water between z and 0: the integral of rho dz; negative above [kg/m^2].
  double column_kg_m2(double z_world_m) const;

 private:
  std::size_t below(double depth_m) const;  // index of the first level deeper than this

  std::vector<WaterLevel> levels_;
  std::vector<double> columns_kg_m2_;  // down to each level
  bool even_ = true;
};

/// Density of sea water at atmospheric pressure [kg/m^3]: the one-atmosphere equation of state of sea water EOS-80
/// (Millero and Poisson 1981; Fofonoff and Millard 1983, UNESCO technical papers in marine science 44). Valid for
/// -2..40 deg C (its T68 and ITS-90 differ by 0.024 % and are not told apart), 0..42 psu, within 0.004 kg/m^3.
/// Compression by depth (about 0.45 kg/m^3 per 100 m) is left out.
double sea_water_density_kg_m3(double temperature_deg_c, double salinity_psu);

}  // namespace uwsim
