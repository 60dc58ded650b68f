#pragma once

#include <cstdint>
#include <vector>

#include "uwsim/core/random.h"
#include "uwsim/world/water.h"
#include "uwsim/world/world.h"

namespace uwsim {

/// What a picture-making sonar hears with: figures that the forward-looking, side-scan and single-beam ones share.
/// Levels in dB re 1 uPa.
struct ImagingAcoustics {
  double frequency_hz = 0;
  double source_level_db = 0;  ///< at 1 m on the axis
  double noise_level_db = 0;   ///< in the receiver's band behind its beam former
  /// Lambert's strength per square metre at normal incidence, of terrain and of solids; `strengths_db`, by label, goes
  /// before these as far as it reaches, where it is not NaN.
  double bottom_strength_db = 0;
  double solid_strength_db = 0;
  std::vector<double> strengths_db;
  double range_max_m = 0;
  int range_bins = 0;  ///< each a range resolution wide: range_max_m / range_bins
  /// Time-varied gain a log10 R + 2 alpha R. Off, the levels are those received.
  bool time_varied_gain = true;
  double gain_db_decade = 0;
  int looks = 1;  ///< independent looks averaged in a cell: 1 is full speckle, 0 none at all

  /// Lambert's mu, as a ratio.
  double strength(Label label) const;
  double bin_m() const { return range_max_m / range_bins; }
  double bin_centre_m(int bin) const { return (bin + 0.5) * bin_m(); }
  /// Throws InvalidValue that names the field.
  void check() const;
  /// Of the water at the head, Francois and Garrison [dB/m].
  double absorption_db_m(const Water& water, double head_z_m) const;
};

/// From an echo's mean power to the level that a picture shows: noise, speckle, gain.
///
/// Many scatterers in a cell with random phases make a complex Gaussian pressure (Goodman 1975, "Statistical properties
/// of laser speckle patterns"), so amplitude is Rayleigh and power exponential: standard deviation = mean. The mean of
/// n looks is a gamma variate of shape n: std = mean / sqrt(n). Noise adds as power, before the draw. A cell's draw is
/// a function of (stream, tick, cell) alone.
class ImagingReceiver {
 public:
  ImagingReceiver(const ImagingAcoustics& acoustics, double absorption_db_m, const RandomStream& random);

  /// echo: mean power over that of the source at 1 m. Received power over 1 uPa^2, without gain.
  double received(double echo, std::uint64_t tick, std::uint32_t cell) const;
  /// Level with the gain of that range [dB re 1 uPa]; always finite.
  float shown_db(double received, double range_m) const;
  double noise() const { return noise_; }

 private:
  ImagingAcoustics acoustics_;
  double absorption_db_m_;
  RandomStream random_;
  double source_, noise_;
};

}  // namespace uwsim
