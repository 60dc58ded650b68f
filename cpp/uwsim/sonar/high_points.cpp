#include "uwsim/sonar/high_points.h"

#include <limits>

namespace uwsim {
namespace {

constexpr double kRounding_m = 1e-6;  // larger than any difference between `nearly` and `exact` within 1000 km

/// A rigid transform of points. `exact` uses std::fma, which returns the same result on every platform, in the order of
/// operations used by BLAS. A mission that transforms the points with NumPy therefore flies a bitwise identical track.
/// `nearly` differs only by rounding and is much faster; it is used to select the points that need `exact`.
class Placing {
 public:
  explicit Placing(const Eigen::Matrix4d& world_from_points)
      : rotation_(world_from_points.topLeftCorner<3, 3>()), origin_m_(world_from_points.topRightCorner<3, 1>()) {}

  Eigen::Vector3d nearly(const Eigen::Vector3d& point) const { return rotation_ * point + origin_m_; }
  Eigen::Vector3d exact(const Eigen::Vector3d& point) const { return {row(0, point), row(1, point), row(2, point)}; }

 private:
  double row(int k, const Eigen::Vector3d& point) const {
    const double xy = std::fma(rotation_(k, 1), point.y(), rotation_(k, 0) * point.x());
    return std::fma(rotation_(k, 2), point.z(), xy) + origin_m_[k];
  }

  Eigen::Matrix3d rotation_;
  Eigen::Vector3d origin_m_;
};

}  // namespace

template <typename T>
std::optional<Eigen::Vector3d> highest_in_corridor(std::span<const T> points_m,
                                                   const Eigen::Matrix4d& world_from_points, const Corridor& corridor) {
  const Placing placing(world_from_points);
  std::optional<Eigen::Vector3d> highest;
  double height_m = -std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k + 2 < points_m.size(); k += 3) {
    const Eigen::Vector3d point(points_m[k], points_m[k + 1], points_m[k + 2]);
    const Eigen::Vector3d nearly = placing.nearly(point);
    if (nearly.z() < height_m - kRounding_m || !corridor.contains(nearly.x(), nearly.y())) continue;
    const Eigen::Vector3d exact = placing.exact(point);
    if (!(exact.z() > height_m)) continue;
    height_m = exact.z();
    highest = exact;
  }
  return highest;
}

template <typename T>
std::vector<double> points_above(std::span<const T> points_m, const Eigen::Matrix4d& world_from_points,
                                 double z_world_m) {
  const Placing placing(world_from_points);
  std::vector<double> above;
  for (std::size_t k = 0; k + 2 < points_m.size(); k += 3) {
    const Eigen::Vector3d point(points_m[k], points_m[k + 1], points_m[k + 2]);
    if (!(placing.nearly(point).z() > z_world_m)) continue;
    const Eigen::Vector3d exact = placing.exact(point);
    above.insert(above.end(), {exact.x(), exact.y(), exact.z()});
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
