#include "uwsim/sonar/high_points.h"

#include <limits>

namespace uwsim {
namespace {

/// One row of a transform times a point. Fused by std::fma, which is the same everywhere, in the order in which BLAS
/// does it: a mission that does this with NumPy flies the same track to the last bit.
double row_times(const Eigen::Matrix4d& transform, int row, const Eigen::Vector3d& point) {
  const double xy = std::fma(transform(row, 1), point.y(), transform(row, 0) * point.x());
  return std::fma(transform(row, 2), point.z(), xy) + transform(row, 3);
}

}  // namespace

template <typename T>
std::optional<Eigen::Vector3d> highest_in_corridor(std::span<const T> points_m,
                                                   const Eigen::Matrix4d& world_from_points, const Corridor& corridor) {
  std::optional<Eigen::Vector3d> highest;
  double height_m = -std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k + 2 < points_m.size(); k += 3) {
    const Eigen::Vector3d point(points_m[k], points_m[k + 1], points_m[k + 2]);
    const double z_m = row_times(world_from_points, 2, point);
    if (!(z_m > height_m)) continue;
    const double x_m = row_times(world_from_points, 0, point), y_m = row_times(world_from_points, 1, point);
    if (!corridor.contains(x_m, y_m)) continue;
    height_m = z_m;
    highest = {x_m, y_m, z_m};
  }
  return highest;
}

template <typename T>
std::vector<double> points_above(std::span<const T> points_m, const Eigen::Matrix4d& world_from_points,
                                 double z_world_m) {
  std::vector<double> above;
  for (std::size_t k = 0; k + 2 < points_m.size(); k += 3) {
    const Eigen::Vector3d point(points_m[k], points_m[k + 1], points_m[k + 2]);
    const double z_m = row_times(world_from_points, 2, point);
    if (!(z_m > z_world_m)) continue;
    above.insert(above.end(), {row_times(world_from_points, 0, point), row_times(world_from_points, 1, point), z_m});
  }
  return above;
}

template std::optional<Eigen::Vector3d> highest_in_corridor(std::span<const float>, const Eigen::Matrix4d&,
                                                            const Corridor&);
template std::optional<Eigen::Vector3d> highest_in_corridor(std::span<const double>, const Eigen::Matrix4d&,
                                                            const Corridor&);
template std::vector<double> points_above(std::span<const float>, const Eigen::Matrix4d&, double);
template std::vector<double> points_above(std::span<const double>, const Eigen::Matrix4d&, double);

}  // namespace uwsim
