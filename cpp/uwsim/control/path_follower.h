#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace uwsim {

/// Where a path leads from a position.
struct Guidance {
  double course_rad = 0;     ///< direction of the velocity, from the world's x, counter-clockwise
  double path_rad = 0;       ///< direction of the segment
  double cross_track_m = 0;  ///< distance from the path, positive to port of it
  double along_m = 0;        ///< distance flown along the path
  double left_m = 0;         ///< remaining distance to the path's end
  double z_world_m = 0;      ///< height of the path abeam of the vehicle
  bool is_done = false;      ///< whether the end is passed
};

/// Line-of-sight guidance along straight segments, with an integral term against disturbances across the track
/// (Borhaug, Pavlov and Pettersen 2008, "Integral LOS control for path following of underactuated marine surface
/// vessels in the presence of constant ocean currents", CDC; Fossen 2021, sec. 12.4):
///
///   course = path - atan((y + s Y) / D),  dY/dt = D y / ((y + s Y)^2 + D^2)
///
/// y the cross-track error, D the look-ahead distance, s the integral gain [m/s]. A vehicle that follows the course
/// over ground at speed U approaches the path as dy/dt = -U y / sqrt(y^2 + D^2) (s = 0): exponentially with the rate
/// U/D near it.
class PathFollower {
 public:
  /// points_m: (n >= 2) corners of the path. Throws InvalidValue.
  PathFollower(std::vector<Eigen::Vector3d> points_m, double lookahead_m, double integral_m_s, double period_s);

  /// Guidance for one control period. A segment ends when the vehicle passes the plane through its end that is normal
  /// to it.
  Guidance guide(const Eigen::Vector3d& position_world_m);

  std::size_t segment = 0;  ///< the present one
  double integral_s = 0;    ///< Y

 private:
  double length_m(std::size_t segment) const { return starts_m_[segment + 1] - starts_m_[segment]; }

  std::vector<Eigen::Vector3d> points_m_;
  std::vector<double> starts_m_;  // length of the path, in the horizontal plane, up to each corner
  double lookahead_m_, integral_m_s_, period_s_;
};

}  // namespace uwsim
