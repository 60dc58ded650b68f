#pragma once

/// Detection of fluctuating echoes in noise. Textbook relations are cited from memory.
///
/// Echoes fluctuate as speckle: the mean of `looks` independent exponential intensities (Rayleigh amplitudes). Their
/// number is the echo's extent over a range cell. The gamma distribution of that mean is approximated by Wilson and
/// Hilferty's cube root (1931, Proc. Natl. Acad. Sci. 17:684), with z a standard normal draw:
/// mean x (1 - 1/(9 L) + z / (3 sqrt L))^3. Intensities are ratios to the noise's mean.
namespace uwsim {

/// The looks that the detector averages: those of the echo, at most 100 (assumed; without this limit the coverage
/// exceeds the manufacturer's table of the EM 2040 below 600 kHz, see `uwsim validate sonar`).
double averaged_looks(double extent_m, double cell_m);

/// Draws an echo's speckle: its intensity over the mean.
double speckle_intensity(double looks, double normal_draw);

/// Draws the received intensity, noise included, of an echo of `echo` times the noise's mean: noncentral chi-squared
/// with 2 L degrees of freedom, by Abdel-Aty's cube root (1954, Biometrika 41:538).
double received_intensity(double echo, double looks, double normal_draw);

/// Decides whether there is an echo, with the same false-alarm probability for any number of looks: averaging steadies
/// the noise, so the threshold falls towards the noise's mean (noncoherent integration: Marcum 1960, IRE Trans. Inf.
/// Theory 6:59).
class DetectionThreshold {
 public:
  /// `detection_threshold_db`: signal-to-noise ratio at which a single look is detected half of the time.
  explicit DetectionThreshold(double detection_threshold_db);

  /// The intensity above which an average of `looks` counts as an echo.
  double intensity(double looks) const;
  /// The probability that noise alone exceeds the threshold.
  double false_alarm() const { return false_alarm_; }
  /// The mean signal-to-noise ratio at which half of the echoes are detected, as a ratio.
  double needed_snr(double looks) const;
  /// The probability of detecting an echo of this mean signal-to-noise ratio.
  double detection_probability(double snr, double looks) const;

 private:
  double normal_draw_;  // draw of the noise at the threshold
  double false_alarm_;
};

/// The standard deviation of a measured range [m]: the part caused by the bottom's speckle, which a ping from the same
/// place repeats, and the part caused by noise.
struct RangeDeviation {
  double speckle_m, noise_m;

  double total_m() const;
};

/// The error of the range to the centre of an echo of length `extent_m` (its rectangular equivalent) with L = extent /
/// cell independent looks; `snr`: mean signal-to-noise ratio, as a ratio.
///
/// Amplitude detection picks the largest sample: extent / sqrt(12) x (1 + 1/snr). Each look is equally likely to be the
/// largest, so it lies anywhere in the echo: the deviation of a uniform distribution, widened by noise. Derived here;
/// Lurton and Augustin's 2010 quality factor (IEEE J. Oceanic Eng. 35:852; its abstract was read, not its text) also
/// rests on an amplitude error that is proportional to the echo's length.
RangeDeviation amplitude_range_deviation(double extent_m, double cell_m, double snr);
/// Phase detection finds the zero crossing of the phase between the two halves of the array by a line fitted over L
/// looks: extent / (0.886 pi) x sigma / sqrt(L), with each look's phase error sigma^2 = 1/snr + 1/(2 snr^2) + floor^2.
/// The phase turns by 0.886 pi over the beam's -3 dB width (halves of a line array). The floor of 0.3 rad is assumed:
/// the decorrelation between the halves that the footprint's extent causes, speckle.
RangeDeviation phase_range_deviation(double extent_m, double cell_m, double snr);

}  // namespace uwsim
