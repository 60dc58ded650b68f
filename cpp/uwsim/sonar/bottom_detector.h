#pragma once

#include <cstdint>

#include "uwsim/acoustics/detection_theory.h"
#include "uwsim/acoustics/sonar_equation.h"
#include "uwsim/sonar/echo.h"

namespace uwsim {

/// How the range of a beam was detected.
enum class Detection : std::uint8_t { kNone = 0, kAmplitude = 1, kPhase = 2, kFalse = 3 };

/// The detection of one beam.
struct BottomDetection {
  Detection kind = Detection::kNone;
  double range_m = 0;
  double intensity = 0;    ///< relative to the mean noise
  double deviation_m = 0;  ///< standard deviation of the range by the detector's own estimate; 0 for noise
};

/// The random causes of one beam's errors, as standard normal draws: the bottom's speckle, which a ping from the same
/// place repeats, and the receiver's noise.
struct BeamDraws {
  double speckle, speckle_range, noise, noise_range;
};

/// Decides on each beam's range. It averages an echo's looks and compares them with a threshold (detection_theory.h).
/// If the echo has at least four looks, it detects by phase, at the range of the beam's axis, with the echo's strength
/// and extent there (assumed: a phase ramp needs several looks; phase then has the smaller error at any signal-to-noise
/// ratio). Otherwise it detects by amplitude, at the centroid of the energy, with the echo's peak.
class BottomDetector {
 public:
  BottomDetector(const SonarFigures& figures, bool range_noise);

  /// Detects the bottom, or nothing.
  BottomDetection bottom(const BeamEcho& echo, const BeamRays& beam, double cell_m, const BeamDraws& draws) const;
  /// The probability that noise exceeds the threshold in any of a beam's range cells.
  double false_alarm(double range_max_m, double cell_m) const;
  /// Detects noise, given a draw from (0, 1) that is below `false_alarm`: the noise exceeds the threshold by an
  /// exponential draw.
  BottomDetection noise(double draw, double false_alarm, double range_m) const;

 private:
  bool range_noise_;
  double system_ratio_;  // signal-to-noise ratio of an echo without any loss
  DetectionThreshold threshold_;
};

}  // namespace uwsim
