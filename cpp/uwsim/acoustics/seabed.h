#pragma once

#include <span>
#include <string_view>

namespace uwsim {

/// A seabed described by the six parameters of APL-UW 1994, "High-Frequency Ocean Environmental Acoustic Models
/// Handbook", TR 9407, ch. IV, table 1. The report itself was not available: table 2 and the equations are taken from
/// UnderwaterAcoustics.jl and uacpy (both public), which restate them, and checked against table 3 as printed there
/// (`uwsim validate sound`).
struct Seabed {
  std::string_view name;
  double density_ratio;    ///< of sediment to water
  double speed_ratio;      ///< of sound in sediment to water
  double loss;             ///< imaginary to real wave number in the sediment
  double volume;           ///< volume scattering cross-section of the sediment, relative to its attenuation
  double strength_cm4;     ///< spectral strength of the relief at a wave number of 1 / cm
  double exponent = 3.25;  ///< of the relief's spectrum

  /// The attenuation of sound in the sediment [dB per wavelength].
  double attenuation_db_wavelength() const;
};

/// The generic seabeds of table 2, from rough rock to clay, by name.
std::span<const Seabed> seabeds();
/// Throws InvalidValue for an unknown name.
const Seabed& seabed(std::string_view name);

/// The model's range of validity [Hz].
inline constexpr double kSeabedLowest_hz = 10e3, kSeabedHighest_hz = 100e3;

/// The backscattering cross-section per unit area and solid angle of a seabed, as a ratio (0 dB = 1), by grazing angle.
///
/// TR 9407, ch. IV.C: the interface's roughness scatters by the Kirchhoff approximation near vertical incidence, by the
/// composite-roughness approximation elsewhere (perturbation theory, averaged over the large-scale slopes, with
/// shadowing) and, for gravel and rock, by an empirical form; logistic functions join them. Scattering from the
/// sediment's volume is added. The Kirchhoff approximation is Mourad and Jackson's closed form of the integral of
/// Jackson, Winebrenner and Ishimaru 1986 (J. Acoust. Soc. Am. 79:1410); its factor b is derived here from that
/// integral at vertical incidence, which also reproduces table 3 (another source's printed b is 3.6 dB below it).
///
/// Valid from 10 to 100 kHz and for speeds of sound in water of 1400 to 1600 m/s, with an uncertainty, as stated by the
/// report, of about 3 dB for well-known sand and silt at grazing angles above 5 degrees, and 10 dB for rock and gravel.
class SeabedBackscatter {
 public:
  /// Throws InvalidValue outside of the range of validity.
  SeabedBackscatter(const Seabed& seabed, double frequency_hz, double sound_speed_m_s);

  double operator()(double grazing_rad) const;

 private:
  double kirchhoff(double grazing_rad) const;
  double perturbation(double grazing_rad) const;
  double volume(double grazing_rad) const;
  double large_roughness(double grazing_rad) const;
  double shadowing(double grazing_rad) const;

  Seabed seabed_;
  double wave_number_1_cm_, vertical_reflection_;  // of power
  double alpha_, q_, a_, b_;                       // of the Kirchhoff approximation
  double slope_;                                   // rms, of the large-scale relief
  double kirchhoff_cosine_;                        // where the Kirchhoff approximation is 15 dB below its maximum
};

}  // namespace uwsim
