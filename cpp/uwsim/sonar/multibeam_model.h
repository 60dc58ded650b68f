#pragma once

#include <cmath>
#include <string>

#include "uwsim/sonar/beam_angles.h"

namespace uwsim {

/// A multibeam's fan: beams evenly spaced over a field of view about the head's forward axis. They are received by one
/// flat array that faces ahead, or by two arrays, each angled to its side ("dual RX").
struct MultibeamModel {
  int number = 0;  ///< 1..4 in messages (`modelTrigger`); 0 for a model that messages cannot select
  std::string name;
  int beams = 0;
  double field_of_view_rad = 0;
  double range_max_m = 0;    ///< a range at or beyond this counts as no echo
  double range_limit_m = 0;  ///< the published LaserScan's range_max: a decoded range above this counts as no echo
  double frequency_hz = 0;
  bool dual_swath = false;
  /// Limit set by the electronics (assumed); travel time may limit the rate further
  double ping_rate_max_hz = 50;
  double tilt_rate_rad_s = 0.0872665;  ///< of the head: 0.1 degree per frame in the paper, at 50 frames/s (assumed)
  /// Angle of each of two receivers from straight ahead to its side; 0 for a single receiver
  double receiver_tilt_rad = 0;
  double gain_db = 0;  ///< of the receiver's display; added to every intensity

  /// Throws InvalidValue naming sonar.<field>.
  void check() const;

  /// The angle between a beam and the normal of its receiving array, on either side.
  double steering_rad(int beam) const { return std::abs(std::abs(angles().at(beam)) - receiver_tilt_rad); }
  BeamAngles angles() const { return even_beam_angles(field_of_view_rad, beams); }
};

/// The EM 2040 MKII as modelled in the seed paper: 1 = 600 kHz single swath, 2 = 700 kHz single (the default), 3 = 600
/// kHz dual, 4 = 700 kHz dual. Throws InvalidValue for other numbers.
const MultibeamModel& em2040(int number);

}  // namespace uwsim
