#pragma once

#include <Eigen/Core>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

namespace uwsim {

/// A strip of the horizontal plane along a vehicle's heading: from half_width_m behind it to ahead_m in front of it,
/// half_width_m to either side. heading_rad: counter-clockwise from east.
class Corridor {
 public:
  Corridor(const Eigen::Vector3d& position_world_m, double heading_rad, double half_width_m, double ahead_m)
      : position_m_(position_world_m),
        cos_(std::cos(heading_rad)),
        sin_(std::sin(heading_rad)),
        half_width_m_(half_width_m),
        ahead_m_(ahead_m) {}

  /// Returns false for NaN.
  bool contains(double x_m, double y_m) const {
    const double dx = x_m - position_m_.x(), dy = y_m - position_m_.y();
    const double along = cos_ * dx + sin_ * dy, across = cos_ * dy - sin_ * dx;
    return along > -half_width_m_ && along < ahead_m_ && std::abs(across) < half_width_m_;
  }

 private:
  Eigen::Vector3d position_m_;
  double cos_, sin_, half_width_m_, ahead_m_;
};

/// Returns the highest of the points (rows of x, y, z), in the world frame, that lie in the corridor; of equally high
/// points, the first. Points with NaN are ignored.
template <typename T>
std::optional<Eigen::Vector3d> highest_in_corridor(std::span<const T> points_m,
                                                   const Eigen::Matrix4d& world_from_points, const Corridor& corridor);

/// Returns the points (rows of x, y, z), in the world frame, that are higher than z_world_m, again as rows. Points with
/// NaN are ignored.
template <typename T>
std::vector<double> points_above(std::span<const T> points_m, const Eigen::Matrix4d& world_from_points,
                                 double z_world_m);

}  // namespace uwsim
