#pragma once

#include <complex>
#include <cstdint>
#include <span>
#include <vector>

#include "uwsim/acoustics/sonar_equation.h"
#include "uwsim/core/parameter.h"
#include "uwsim/core/random.h"
#include "uwsim/world/water.h"
#include "uwsim/world/world.h"

namespace uwsim {

/// The acoustic parameters common to all imaging sonars. Levels in dB re 1 uPa.
struct ImagingAcoustics {
  double frequency_hz = 0;
  double source_level_db = 0;  ///< at 1 m on the axis
  double noise_level_db = 0;   ///< in the receiver's band, after beamforming
  /// The Lambert scattering strength per square metre at normal incidence, for the terrain and for solids.
  /// `strengths_db`, which is indexed by label, takes precedence where it has an entry; NaN entries are ignored.
  double bottom_strength_db = 0;
  double solid_strength_db = 0;
  std::vector<double> strengths_db;
  double range_max_m = 0;
  int range_bins = 0;            ///< the range resolution is range_max_m / range_bins
  bool time_varied_gain = true;  ///< whether a log10 R + 2 alpha R is added; if not, levels are as received
  double gain_db_decade = 0;     ///< a
  int looks = 1;                 ///< independent looks averaged in a cell: 1 for full speckle, 0 for none
  bool multipath = false;        ///< whether echoes with several bounces are received, see surface_ghosts.cpp
  /// By label: a seabed, which takes precedence over the Lambert strength, and the fluid that determines reflections.
  /// Labels beyond the end of this list follow Lambert's law and reflect like a default BottomMaterial.
  std::vector<BottomMaterial> materials;

  /// The Lambert coefficient mu of a surface, as a linear ratio.
  double strength(Label label) const;
  double bin_m() const { return range_max_m / range_bins; }
  double bin_centre_m(int bin) const { return (bin + 0.5) * bin_m(); }
  /// Absorption in the water at the head, by Francois and Garrison [dB/m].
  double absorption_db_m(const Water& water, double head_z_m) const;
};

/// The parameters of ImagingAcoustics by name, except strengths_db.
std::span<const Parameter> imaging_acoustics_parameters();
/// Creates the acoustics from a complete set of parameters. Throws InvalidValue for strengths out of range.
ImagingAcoustics imaging_acoustics(const ParameterValues& parameters, const std::vector<double>& strengths_db = {},
                                   const std::vector<BottomMaterial>& materials = {});

/// Converts an echo's mean power to the displayed level: speckle, noise, gain.
///
/// Many scatterers in a cell with random phases make a complex Gaussian pressure (Goodman 1975, "Statistical properties
/// of laser speckle patterns"), so amplitude is Rayleigh and power exponential: standard deviation = mean. The mean of
/// n looks is a gamma variate of shape n: std = mean / sqrt(n). Speckle is determined by the position (FanSpeckle). The
/// receiver's noise, also complex Gaussian, is added to the pressure and is a function of (stream, ping, cell) only.
class ImagingReceiver {
 public:
  ImagingReceiver(const ImagingAcoustics& acoustics, double absorption_db_m, const RandomStream& random);

  /// The cells of one beam in a ping: the ping's number, and the numbers of the cells within the ping, which start at
  /// `first_cell` and increase by `cell_step` from bin to bin.
  struct Cells {
    std::uint64_t ping;
    std::uint32_t first_cell, cell_step;
  };

  /// Replaces the mean echo power of each bin, relative to the source's at 1 m, by the received power relative to 1
  /// uPa^2, without gain. Also sets the displayed levels, with the gain at that range [dB re 1 uPa]; they are always
  /// finite. `speckle`: the beam's amplitudes, see FanSpeckle::of_beam.
  void receive(const Cells& cells, std::span<const std::complex<float>> speckle, std::span<double> power,
               std::span<float> level_db) const;
  double noise() const { return noise_; }
  /// The mean echo power that equals the noise, relative to the source's power at 1 m.
  double echo_at_noise() const { return noise_ / source_; }

 private:
  RandomStream random_;
  int looks_;
  double source_, noise_;
  std::vector<float> gain_db_;  // by bin
};

}  // namespace uwsim
