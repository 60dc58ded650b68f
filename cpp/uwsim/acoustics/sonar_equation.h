#pragma once

/// Textbook relations are cited from memory; chapters and pages were not checked against the books.
namespace uwsim {

/// The figures of an active sonar: transmitter, receiver and detector. Levels in dB: source re 1 uPa at 1 m, noise re
/// 1 uPa within the receiver's band.
struct SonarFigures {
  double frequency_hz = 400e3;
  double beam_width_along_rad = 0.007;   ///< -3 dB, one way: the transmitter's, across the fan's plane
  double beam_width_across_rad = 0.012;  ///< -3 dB, one way: a receiving beam's, within the fan's plane
  double pulse_length_s = 1e-4;
  double bandwidth_hz = 1e4;  ///< of the pulse, which is compressed to 1 / bandwidth
  double source_level_db = 200;
  double directivity_index_db = 20;  ///< of a receiving beam
  double noise_level_db = 45;
  double detection_threshold_db = 13;  ///< signal-to-noise ratio with a detection probability of one half

  /// Throws InvalidValue that names sonar.<field>.
  void check() const;
  /// 10 log10 (bandwidth x pulse length): the gain of compressing a long pulse.
  double processing_gain_db() const;
  /// SL + PG + DI - NL: the signal-to-noise ratio of an echo without any loss [dB].
  double figure_db() const;
  /// Range resolution of the compressed pulse, c / (2 B) [m].
  double range_cell_m(double sound_speed_m_s) const;
  /// Equivalent solid angle of the two-way beam: the integral of the product of both patterns, assumed Gaussian,
  /// pi / (4 ln 2) x both widths [sr].
  double beam_solid_angle_sr() const;
};

/// How a bottom scatters sound back.
struct BottomMaterial {
  double strength_db = -30;  ///< backscatter of a square metre at normal incidence; Lambert's law at others
  double relief = 0.1;       ///< rms slope of the relief across a footprint, which spreads the echo in range
};

/// The area of bottom that contributes to one range cell at normal incidence [m^2]: the whole footprint, Omega R^2, if
/// its relief is lower than a range cell (beam-limited, echoes fall by 20 log R); the fraction cell / spread of it if
/// the relief spreads the echo over more (pulse-limited, 30 log R). Spread = relief x width of the footprint, with the
/// geometric mean of both widths, R sqrt(along x across) (derived: relief of a given slope is proportional to the
/// footprint).
double nadir_area_m2(const SonarFigures& sonar, const BottomMaterial& bottom, double range_m, double sound_speed_m_s);

/// Signal-to-noise ratio of the bottom straight below [dB], the active sonar equation (Urick 1983, "Principles of
/// Underwater Sound", ch. 2 and 8): SL + PG + DI - NL + BS + 10 log A - 40 log R - 2 alpha R.
double nadir_snr_db(const SonarFigures& sonar, const BottomMaterial& bottom, double range_m, double sound_speed_m_s,
                    double absorption_db_m);

/// Echoes fluctuate as speckle: the mean of `looks` independent exponential intensities (Rayleigh amplitudes). The
/// detector averages over the echo's length and compares with a threshold that an echo with a mean signal-to-noise
/// ratio of DT passes half of the time. The gamma distribution of that mean is approximated by Wilson and Hilferty's
/// cube root (1931, Proc. Natl. Acad. Sci. 17:684): with z a standard normal draw,
/// mean x (1 - 1/(9 L) + z / (3 sqrt L))^3.
///
/// The draw of an intensity over that of the noise; `snr`: the mean signal-to-noise ratio, as a ratio, not in dB.
double fading_intensity(double snr, double looks, double normal_draw);
/// The threshold in the same unit.
double intensity_threshold(double detection_threshold_db, double looks);
/// The probability that the bottom is detected.
double detection_probability(double snr, double looks, double detection_threshold_db);
/// The probability that noise alone passes the threshold in one range cell, one look: exp(-threshold).
double false_alarm_probability(double detection_threshold_db);

/// Standard deviation [m] of the range to the centre of an echo of length `extent_m` (its rectangular equivalent) with
/// L = extent / cell independent looks, for amplitude detection and for phase detection.
///
/// Amplitude detection picks the largest sample: extent / sqrt(12) x (1 + 1/snr). Each look is equally likely to be the
/// largest, so it lies anywhere in the echo: the deviation of a uniform distribution, widened by noise. Derived here;
/// Lurton and Augustin's 2010 quality factor (IEEE J. Oceanic Eng. 35:852; its abstract was read, not its text) also
/// rests on an amplitude error that is proportional to the echo's length.
double amplitude_range_std_m(double extent_m, double cell_m, double snr);
/// Phase detection finds the zero crossing of the phase between the two halves of the array by a line fitted over L
/// looks: extent / (0.886 pi) x sigma / sqrt(L), with each look's phase error sigma^2 = 1/snr + 1/(2 snr^2) + floor^2.
/// The phase turns by 0.886 pi over the beam's -3 dB width (halves of a line array). The floor of 0.3 rad is assumed:
/// the decorrelation between the halves that the footprint's extent causes.
double phase_range_std_m(double extent_m, double cell_m, double snr);

}  // namespace uwsim
