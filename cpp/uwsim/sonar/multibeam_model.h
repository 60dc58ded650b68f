#pragma once

#include <string>

namespace uwsim {

/// A multibeam's fan: beams spread evenly over a field of view about the head's forward axis.
struct MultibeamModel {
  int number = 0;  ///< 1..4, as on the wire (`modelTrigger`); 0: not of the wire
  std::string name;
  int beams = 0;
  double field_of_view_rad = 0;
  double range_max_m = 0;    ///< a range at or past it is no echo
  double range_limit_m = 0;  ///< published LaserScan's range_max: a decoded range above it is no echo
  double frequency_hz = 0;
  bool dual_swath = false;
  double ping_rate_max_hz = 50;        ///< of the electronics; travel time may allow less (50: assumed)
  double tilt_rate_rad_s = 0.0872665;  ///< of the head: published 0.1 degree a frame, at 50 frames/s (assumed)

  /// Throws InvalidValue that names sonar.<field>.
  void check() const;

  double angle_min_rad() const { return -field_of_view_rad / 2; }
  double angle_increment_rad() const { return field_of_view_rad / (beams - 1); }
  double angle_rad(int beam) const { return angle_min_rad() + beam * angle_increment_rad(); }
};

/// The EM 2040 MKII as the seed paper models it: 1 = 600 kHz single swath, 2 = 700 kHz single (the default),
/// 3 = 600 kHz dual, 4 = 700 kHz dual. Throws InvalidValue for other numbers.
const MultibeamModel& em2040(int number);

}  // namespace uwsim
