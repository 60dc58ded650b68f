#include "uwsim/mapping/map_ray.h"

#include <array>
#include <cmath>
#include <limits>
#include <optional>

namespace uwsim {
namespace {

constexpr double kNeverCrosses = std::numeric_limits<double>::max();  // the same value as in OctoMap

/// The state of a ray that walks from voxel to voxel, computed as in OctoMap.
class MapRay {
 public:
  MapRay(double resolution_m, const Eigen::Vector3f& origin_m, const Eigen::Vector3f& direction)
      : resolution_m_(resolution_m), origin_m_(origin_m) {
    const float x = direction.x(), y = direction.y(), z = direction.z();
    const auto length = static_cast<float>(std::sqrt(static_cast<double>(x * x + y * y + z * z)));
    for (std::size_t i = 0; i < 3; ++i) {
      const auto axis = static_cast<Eigen::Index>(i);
      key_[i] = static_cast<int>(std::floor(1.0 / resolution_m * static_cast<double>(origin_m[axis]))) + kHalfExtent;
      const float along = length > 0 ? direction[axis] / length : direction[axis];
      step_[i] = (along > 0) - (along < 0);
      const double border = centre_m(key_[i]) + step_[i] * resolution_m * 0.5;
      const bool moves = step_[i] != 0;
      next_[i] = moves ? (border - static_cast<double>(origin_m[axis])) / static_cast<double>(along) : kNeverCrosses;
      stride_[i] = moves ? resolution_m / std::abs(static_cast<double>(along)) : kNeverCrosses;
    }
  }

  const VoxelKey& key() const { return key_; }

  /// Crosses the next face; returns false if the ray leaves the cube.
  bool step() {
    const std::size_t axis = next_[0] < next_[1] ? (next_[0] < next_[2] ? 0 : 2) : (next_[1] < next_[2] ? 1 : 2);
    const int beyond = key_[axis] + step_[axis];
    if (step_[axis] == 0 || beyond < 0 || beyond >= 2 * kHalfExtent) return false;
    key_[axis] = beyond;
    next_[axis] += stride_[axis];
    return true;
  }

  /// Whether the voxel's centre is farther from the origin than max_range_m.
  bool is_beyond(double max_range_m) const {
    const Eigen::Vector3f end_m =
        Eigen::Vector3d(centre_m(key_[0]), centre_m(key_[1]), centre_m(key_[2])).cast<float>();
    double square = 0;
    for (Eigen::Index i = 0; i < 3; ++i) {
      square += static_cast<double>((end_m[i] - origin_m_[i]) * (end_m[i] - origin_m_[i]));
    }
    return square > max_range_m * max_range_m;
  }

 private:
  double centre_m(int k) const { return (static_cast<double>(k - kHalfExtent) + 0.5) * resolution_m_; }

  const double resolution_m_;
  const Eigen::Vector3f origin_m_;
  VoxelKey key_;
  std::array<int, 3> step_;
  /// Distances along the ray: to the next face across each axis, and between two faces [m]
  std::array<double, 3> next_, stride_;
};

}  // namespace

MapRayHit cast_map_ray(const MapEngine& engine, double resolution_m, const Eigen::Vector3f& origin_m,
                       const Eigen::Vector3f& direction, bool ignore_unknown, double max_range_m) {
  MapRay ray(resolution_m, origin_m, direction);
  for (;;) {
    const std::optional<float> log_odds = engine.log_odds_at(ray.key());
    if (log_odds && is_occupied(*log_odds)) return {MapRayEnd::hit, ray.key()};
    if (!log_odds && !ignore_unknown) return {MapRayEnd::unknown, ray.key()};
    if (!ray.step()) return {MapRayEnd::free, ray.key()};
    if (max_range_m > 0 && ray.is_beyond(max_range_m)) return {MapRayEnd::free, ray.key()};
  }
}

void follow_map_ray(double resolution_m, const Eigen::Vector3f& origin_m, const Eigen::Vector3f& direction,
                    double max_range_m, const std::function<bool(const VoxelKey&)>& visit) {
  MapRay ray(resolution_m, origin_m, direction);
  while (visit(ray.key()) && ray.step() && !(max_range_m > 0 && ray.is_beyond(max_range_m))) {
  }
}

}  // namespace uwsim
