#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace uwsim {

/// The equations for the speed of sound in water. Each is valid only in its range of temperature, salinity and depth.
enum class SoundSpeedEquation {
  /// The international standard: Chen and Millero 1977, J. Acoust. Soc. Am. 62:1129 (Fofonoff and Millard 1983, UNESCO
  /// 44), with the ITS-90 coefficients of Wong and Zhu 1995, J. Acoust. Soc. Am. 97:1732.
  kUnesco,
  /// Del Grosso 1974, J. Acoust. Soc. Am. 56:1084, with the coefficients of Wong and Zhu 1995. Agrees better than the
  /// UNESCO equation with travel times measured in the deep ocean (Meinen and Watts 1997, J. Acoust. Soc. Am.
  /// 102:2058).
  kDelGrosso,
  /// Belogol'skii, Sekoyan, Samorukova, Stefanov and Levtsov 1999, Measurement Techniques 42:406: pure water.
  kBelogolskii,
  /// Leroy, Robinson and Goldsmith 2008, J. Acoust. Soc. Am. 124:2774, at 45 degrees of latitude (the term in latitude
  /// is at most 0.05 m/s per 1000 m of depth).
  kLeroy,
  /// Mackenzie 1981, J. Acoust. Soc. Am. 70:807.
  kMackenzie,
  /// Medwin 1975, J. Acoust. Soc. Am. 58:1318.
  kMedwin,
};

/// Extremes of temperature, salinity and depth, either of a body of water or of an equation's range of validity.
struct WaterRange {
  double coldest_deg_c, warmest_deg_c, freshest_psu, saltiest_psu, deepest_m;

  bool covers(const WaterRange& other) const;
  /// A description such as "0 to 40 deg C, 0 to 40 psu, down to 9700 m".
  std::string text() const;
};

WaterRange valid_range(SoundSpeedEquation equation);

/// Names in the order of the enumerators: unesco, del_grosso, belogolskii, leroy, mackenzie, medwin.
const std::vector<std::string>& sound_speed_equation_names();
/// The name that selects the best equation automatically.
inline constexpr std::string_view kAutomaticSoundSpeed = "automatic";
/// Returns the equation with this name. Throws InvalidValue listing the valid names.
SoundSpeedEquation sound_speed_equation(std::string_view name);
const std::string& name_of(SoundSpeedEquation equation);

/// The most accurate equation that is valid throughout the water. A single equation is used, so that no transition
/// between two equations bends rays: Belogol'skii for water without salt; Del Grosso for a sea deeper than 1000 m;
/// otherwise UNESCO, or Leroy (colder than 0 deg C or saltier than 40 psu). If no equation covers the water (below -1
/// deg C, above 42 psu), UNESCO.
SoundSpeedEquation best_sound_speed_equation(const WaterRange& water);

/// Speed of sound [m/s]. An equation is extrapolated beyond its range. Throws InvalidValue unless the temperature is in
/// [-2, 40] deg C, the salinity in [0, 45] psu, the depth in [0, 12000] m and the gauge pressure in [0, 2e8] Pa.
double sound_speed_m_s(SoundSpeedEquation equation, double temperature_deg_c, double salinity_psu, double depth_m,
                       double gauge_pressure_pa);
/// Speed of sound under a column of this compressible water at standard gravity. The equation is selected by name or by
/// "automatic".
double sound_speed_m_s(double temperature_deg_c, double salinity_psu, double depth_m,
                       std::string_view equation = kAutomaticSoundSpeed);

}  // namespace uwsim
