#pragma once

/// Textbook relations are cited from memory; chapters and pages were not checked against the books.
namespace uwsim {

/// What an active sonar sends, hears and decides by. Levels in dB: of the source re 1 uPa at 1 m, of the noise re 1 uPa
/// within the receiver's band.
struct SonarFigures {
  double frequency_hz = 400e3;
  double beam_width_along_rad = 0.007;   ///< -3 dB, one way: of the transmitter, across the fan's plane
  double beam_width_across_rad = 0.012;  ///< -3 dB, one way: of a receiving beam, within the fan's plane
  double pulse_length_s = 1e-4;
  double bandwidth_hz = 1e4;  ///< of the pulse; the echo is compressed to 1 / bandwidth
  double source_level_db = 200;
  double directivity_index_db = 20;  ///< of a receiving beam
  double noise_level_db = 45;
  double detection_threshold_db = 13;  ///< the signal-to-noise ratio that is detected half of the time

  /// Throws InvalidValue that names sonar.<field>.
  void check() const;
  /// 10 log10 (bandwidth x pulse length): what compressing a long pulse gains.
  double processing_gain_db() const;
  /// SL + PG + DI - NL: the signal-to-noise ratio of an echo that lost nothing [dB].
  double figure_db() const;
  /// Length in range of the compressed pulse, c / (2 B) [m].
  double range_cell_m(double sound_speed_m_s) const;
  /// Solid angle of the two-way beam as if it were even, the integral of the product of both patterns, which are taken
  /// for Gaussian: pi / (4 ln 2) x both widths [sr].
  double beam_solid_angle_sr() const;
};

/// What a bottom gives back.
struct BottomMaterial {
  double strength_db = -30;  ///< backscatter of a square metre at normal incidence; by Lambert's law at others
  double relief = 0.1;       ///< rms slope of its relief across a footprint, which spreads the echo in range
};

/// Bottom that scatters one range cell's worth at normal incidence [m^2]: the whole footprint, Omega R^2, where its
/// relief is lower than a range cell (beam-limited, echoes fall by 20 log R), and of it the share cell / spread where
/// relief spreads the echo over more (pulse-limited, 30 log R). Spread = relief x width of the footprint, the root of
/// the product of both, R sqrt(along x across) (derived: relief of a given slope is proportional to the footprint).
double nadir_area_m2(const SonarFigures& sonar, const BottomMaterial& bottom, double range_m, double sound_speed_m_s);

/// Signal-to-noise ratio of the bottom straight below [dB], the active sonar equation (Urick 1983, "Principles of
/// Underwater Sound", ch. 2 and 8): SL + PG + DI - NL + BS + 10 log A - 40 log R - 2 alpha R.
double nadir_snr_db(const SonarFigures& sonar, const BottomMaterial& bottom, double range_m, double sound_speed_m_s,
                    double absorption_db_m);

/// Echoes fluctuate as speckle does: a mean of `looks` independent exponential intensities (Rayleigh amplitudes). The
/// detector averages over the echo's length and compares with a threshold that a mean signal-to-noise ratio of
/// DT passes half of the time. Their gamma distribution by Wilson and Hilferty's cube root (1931, Proc. Natl. Acad.
/// Sci. 17:684): with z a standard normal draw, mean x (1 - 1/(9 L) + z / (3 sqrt L))^3.
/// Intensity over noise, of a mean signal-to-noise ratio (as a ratio, not dB).
double fading_intensity(double snr, double looks, double normal_draw);
/// The threshold in the same unit.
double intensity_threshold(double detection_threshold_db, double looks);
/// Probability that the bottom is detected.
double detection_probability(double snr, double looks, double detection_threshold_db);
/// Probability that noise alone passes the threshold in one range cell, one look: exp(-threshold).
double false_alarm_probability(double detection_threshold_db);

/// Standard deviation [m] of the range to the middle of an echo that is `extent_m` long in range (its even equivalent)
/// and holds extent / cell independent looks L, by amplitude and by phase.
///
/// Amplitude, the largest sample: extent / sqrt(12) x (1 + 1/snr). Of looks alike, each is as likely to fade least, so
/// that the largest lies anywhere in the echo, about its middle: an even distribution's deviation; noise widens it.
/// Derived; that amplitude's error goes with the echo's length is also the base of Lurton and Augustin's 2010 quality
/// factor (IEEE J. Oceanic Eng. 35:852; its abstract was read, not its text).
double amplitude_range_std_m(double extent_m, double cell_m, double snr);
/// Phase, the zero crossing between two halves of the array: extent / (0.886 pi) x sigma / sqrt(L), a line fitted over
/// L looks, of which each errs by sigma^2 = 1/snr + 1/(2 snr^2) + floor^2. The phase turns by 0.886 pi over the
/// beam's -3 dB width (a line array's halves); floor 0.3 rad is assumed: what the footprint's own extent
/// decorrelates between the halves.
double phase_range_std_m(double extent_m, double cell_m, double snr);

}  // namespace uwsim
