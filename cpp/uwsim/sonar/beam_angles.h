#pragma once

namespace uwsim {

/// The angles of a fan's beams about the sonar's +z axis: 0 straight ahead (+x), positive to port. Beam 0 is the
/// outermost beam to starboard; the others follow at even spacing, like angle_min and angle_increment in
/// sensor_msgs/LaserScan.
struct BeamAngles {
  double first_rad;
  double spacing_rad;

  double at(int beam) const { return first_rad + beam * spacing_rad; }
};

/// The angles of `beams` >= 2 beams whose outermost axes are `field_of_view_rad` apart.
inline BeamAngles even_beam_angles(double field_of_view_rad, int beams) {
  return {-field_of_view_rad / 2, field_of_view_rad / (beams - 1)};
}

}  // namespace uwsim
