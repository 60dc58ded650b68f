#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace uwsim {

/// The guidance that a path follower computes at one position.
struct Guidance {
  double course_rad = 0;     ///< direction of the commanded velocity, counter-clockwise from the world's x axis
  double path_rad = 0;       ///< direction of the path segment
  double cross_track_m = 0;  ///< distance from the path, positive to port
  double along_m = 0;        ///< distance travelled along the path
  double left_m = 0;         ///< remaining distance to the path's end
  double z_world_m = 0;      ///< height of the path abeam of the vehicle
  bool is_done = false;      ///< whether the end has been passed
};

/// Line-of-sight guidance along straight segments, with an integral term against disturbances across the track
/// (Borhaug, Pavlov and Pettersen 2008, "Integral LOS control for path following of underactuated marine surface
/// vessels in the presence of constant ocean currents", CDC; Fossen 2021, sec. 12.4):
///
///   course = path - atan((y + s Y) / D),  dY/dt = D y / ((y + s Y)^2 + D^2)
///
/// where y is the cross-track error, D the look-ahead distance and s the integral gain [m/s]. For s = 0, a vehicle that
/// follows the course over ground at speed U approaches the path according to dy/dt = -U y / sqrt(y^2 + D^2), which
/// near the path is exponential with the rate U/D.
class PathFollower {
 public:
  /// points_m: the vertices of the path, at least two. Throws InvalidValue.
  PathFollower(std::vector<Eigen::Vector3d> points_m, double lookahead_m, double integral_m_s, double period_s);

  /// Computes guidance for one control period. A segment is completed when the vehicle passes the plane through the
  /// segment's end that is perpendicular to it.
  Guidance guide(const Eigen::Vector3d& position_world_m);
  /// Adapts the pace for one control period, and returns the velocity over ground [m/s] along a course. While the
  /// thrusters deliver less than the requested force, the vehicle slows down, so that thrust across the path suffices.
  /// `force_share`: see MotionController.
  Eigen::Vector2d pace(double course_rad, double speed_m_s, double force_share);

  std::size_t segment = 0;  ///< index of the present segment
  double integral_s = 0;    ///< Y
  double speed_share = 1;   ///< fraction of the full speed, as set by `pace`

 private:
  double length_m(std::size_t segment) const { return starts_m_[segment + 1] - starts_m_[segment]; }

  std::vector<Eigen::Vector3d> points_m_;
  std::vector<double> starts_m_;  // horizontal length of the path up to each vertex
  double lookahead_m_, integral_m_s_, period_s_;
};

}  // namespace uwsim
