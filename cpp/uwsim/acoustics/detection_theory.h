#pragma once

/// Detection of fluctuating echoes in noise.
///
/// Echoes fluctuate as speckle: an echo is the mean of `looks` independent exponential intensities (Rayleigh
/// amplitudes), and its number of looks is its extent divided by the range cell. The gamma distribution of this mean is
/// approximated by the Wilson-Hilferty cube root (1931, Proc. Natl. Acad. Sci. 17:684), where z is a standard normal
/// draw: mean x (1 - 1/(9 L) + z / (3 sqrt L))^3. Its cumulative probability is within 0.013 of scipy's gamma
/// distribution for one look, and 0.002 for four or more. Intensities are relative to the mean noise.
namespace uwsim {

/// The number of looks that the detector averages: all looks of the echo, but at most 100. The limit is assumed;
/// without it, the EM 2040's coverage below 600 kHz would exceed the manufacturer's table (see `uwsim validate sonar`).
double averaged_looks(double extent_m, double cell_m);

/// Draws the speckle of an echo: its intensity relative to its mean.
double speckle_intensity(double looks, double normal_draw);

/// Draws the received intensity, including noise, for an echo whose mean is `echo` times the mean noise: noncentral
/// chi-squared with 2 L degrees of freedom, approximated by the Abdel-Aty cube root (1954, Biometrika 41:538), whose
/// cumulative probability is within 0.022 of scipy's for one look, and 0.008 for four or more.
double received_intensity(double echo, double looks, double normal_draw);

/// Decides whether there is an echo. The false-alarm probability is the same for any number of looks. Averaging more
/// looks reduces the fluctuations of the noise, so the threshold approaches the mean noise (noncoherent integration:
/// Marcum 1960, IRE Trans. Inf. Theory 6:59).
class DetectionThreshold {
 public:
  /// `detection_threshold_db`: signal-to-noise ratio at which a single look is detected half of the time.
  explicit DetectionThreshold(double detection_threshold_db);

  /// The intensity above which an average of `looks` counts as an echo.
  double intensity(double looks) const;
  /// The probability that noise alone exceeds the threshold.
  double false_alarm() const { return false_alarm_; }
  /// The mean signal-to-noise ratio at which half of the echoes are detected, as a linear ratio.
  double needed_snr(double looks) const;
  /// The probability of detecting an echo with this mean signal-to-noise ratio.
  double detection_probability(double snr, double looks) const;

 private:
  double normal_draw_;  // the noise at the threshold, as a normal deviate
  double false_alarm_;
};

/// The standard deviation of a measured range [m], in two parts: one due to the bottom's speckle, which is the same for
/// pings from the same place, and one due to noise.
struct RangeDeviation {
  double speckle_m, noise_m;

  double total_m() const;
};

/// The error of amplitude detection in locating the centre of an echo in range. `extent_m` is the echo's length,
/// expressed as the length of an equivalent rectangle; it contains L = extent / cell independent looks. `snr` is the
/// mean signal-to-noise ratio, as a linear ratio.
///
/// Amplitude detection picks the largest sample, so its deviation is extent / sqrt(12) x (1 + 1/snr): each look is
/// equally likely to be the largest, so the detected range is uniformly distributed over the echo, and noise widens
/// this distribution. Derived here; Lurton and Augustin's 2010 quality factor (IEEE J. Oceanic Eng. 35:852; only its
/// abstract was consulted) is also based on an amplitude error that is proportional to the echo's length.
RangeDeviation amplitude_range_deviation(double extent_m, double cell_m, double snr);
/// The range error of phase detection, which finds the zero crossing of the phase difference between the two halves of
/// the array by fitting a line over L looks: extent / (0.886 pi) x sigma / sqrt(L), where each look's phase error is
/// sigma^2 = 1/snr + 1/(2 snr^2) + floor^2. The phase changes by 0.886 pi over the beam's -3 dB width (halves of a line
/// array). The floor of 0.3 rad is assumed; it represents speckle, which decorrelates the two halves because of the
/// footprint's extent.
RangeDeviation phase_range_deviation(double extent_m, double cell_m, double snr);

}  // namespace uwsim
