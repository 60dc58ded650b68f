#pragma once

#include <cstdint>

#include "uwsim/acoustics/detection_theory.h"
#include "uwsim/acoustics/sonar_equation.h"
#include "uwsim/sonar/echo.h"

namespace uwsim {

/// The method by which a beam's range was detected.
enum class Detection : std::uint8_t { kNone = 0, kAmplitude = 1, kPhase = 2, kFalse = 3 };

/// The detection of one beam.
struct BottomDetection {
  Detection kind = Detection::kNone;
  double range_m = 0;
  double intensity = 0;    ///< relative to the mean noise and reverberation
  double deviation_m = 0;  ///< standard deviation of the range by the detector's own estimate
};

/// The random draws for one beam's errors, each standard normal: one for the bottom's speckle, which is the same for
/// pings from the same place, and one for the receiver's noise.
struct BeamDraws {
  double speckle, speckle_range, noise, noise_range;
};

/// Determines each beam's range. The detector averages the looks of an echo and compares the result with a threshold
/// (detection_theory.h). An echo with at least four looks is detected by phase, at the range of the beam's axis, with
/// the echo's strength and extent at that range (assumed: a phase ramp needs several looks; with them, phase detection
/// has the smaller error at any signal-to-noise ratio). Any other echo is detected by amplitude, at the centroid of its
/// energy, with its peak.
class BottomDetector {
 public:
  BottomDetector(const SonarParameters& parameters, bool range_noise);

  /// Returns the detection of a beam's echo, if any. `background`: noise and reverberation, relative to the noise in an
  /// unsteered beam.
  BottomDetection bottom(const BeamEcho& echo, const BeamRays& beam, double cell_m, const BeamDraws& draws,
                         double background = 1) const;
  /// The signal-to-noise ratio of a lossless echo in an unsteered beam.
  double system_ratio() const { return system_ratio_; }
  /// The probability that noise exceeds the threshold in at least one of a beam's range cells.
  double false_alarm(double range_max_m, double cell_m) const;
  /// Returns a false detection, given a draw from (0, 1) that is below `false_alarm`. The amount by which the noise
  /// exceeds the threshold is exponentially distributed. The detector treats it as an echo of one cell.
  BottomDetection noise(double draw, double false_alarm, double range_m, double cell_m) const;

 private:
  bool range_noise_;
  double system_ratio_;  // see system_ratio
  DetectionThreshold threshold_;
};

}  // namespace uwsim
