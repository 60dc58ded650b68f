#include "uwsim/mapping/distance_field.h"

#include <dynamicEDT3D/dynamicEDT3D.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

constexpr std::size_t kVoxelsMax = 32'000'000;
constexpr double kVoxelsAcrossMax = 1000;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

int squared_voxels(double max_distance_m, double resolution_m) {
  require(max_distance_m >= resolution_m && max_distance_m <= kVoxelsAcrossMax * resolution_m, "max_distance_m",
          max_distance_m, "must be from one to 1,000 voxels of " + std::to_string(resolution_m) + " m");
  const double voxels = max_distance_m / resolution_m;
  return static_cast<int>(std::ceil(voxels * voxels));
}

}  // namespace

struct DistanceField::Impl {
  Impl(const OccupancyMap& map, const Eigen::Vector3d& low, const Eigen::Vector3d& high, const Options& chosen)
      : resolution_m(map.resolution_m()),
        low_m(low),
        high_m(high),
        options(chosen),
        transform(squared_voxels(chosen.max_distance_m, map.resolution_m())) {
    const StateGrid states = map.states_in(low_m, high_m, kVoxelsMax);
    shape = states.shape;
    low_centre_m = states.low_centre_world_m;
    require(!states.states.empty(), "box", low.transpose(), "contains no voxel of the map's cube");
    is_obstacle.assign(states.states.size(), false);
    // dynamicEDT3D leaves the outermost layer of its grid as it is.
    transform.initializeEmpty(shape[0] + 2, shape[1] + 2, shape[2] + 2);
    set(states);
  }

  std::size_t set(const StateGrid& now) {
    std::size_t changed = 0, i = 0;
    for (int x = 1; x <= shape[0]; ++x) {
      for (int y = 1; y <= shape[1]; ++y) {
        for (int z = 1; z <= shape[2]; ++z, ++i) {
          const std::int8_t state = now.states[i];
          const bool blocks = state == 1 || (state < 0 && options.unknown_is_occupied);
          if (blocks == is_obstacle[i]) continue;
          if (blocks) {
            transform.occupyCell(x, y, z);
          } else {
            transform.clearCell(x, y, z);
          }
          is_obstacle[i] = blocks;
          ++changed;
        }
      }
    }
    if (changed > 0) transform.update(false);
    return changed;
  }

  double at(int x, int y, int z) const {
    const double voxels = std::sqrt(static_cast<double>(transform.getSQCellDistance(x + 1, y + 1, z + 1)));
    return std::min(voxels * resolution_m, options.max_distance_m);
  }

  /// The eight voxels around a point, and the point's position between them; `inside` is false outside the box of
  /// centres.
  struct Corners {
    bool inside;
    std::array<double, 3> along;
    double distances_m[2][2][2];
  };

  Corners corners(const double* point) const {
    Corners found{true, {}, {}};
    std::array<int, 3> first{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      require(std::isfinite(point[axis]), "points_world_m", point[axis], "must be finite");
      const double place = (point[axis] - low_centre_m[Eigen::Index(axis)]) / resolution_m;
      const double last = shape[axis] - 1;
      if (!(place >= -kRounding && place <= last + kRounding)) found.inside = false;
      if (!found.inside) continue;
      const double lower = std::clamp(std::floor(place), 0.0, std::max(last - 1, 0.0));
      first[axis] = static_cast<int>(lower);
      found.along[axis] = std::clamp(place - lower, 0.0, 1.0);
    }
    if (!found.inside) return found;
    for (int i = 0; i < 2; ++i) {
      for (int j = 0; j < 2; ++j) {
        for (int k = 0; k < 2; ++k) {
          found.distances_m[i][j][k] = at(std::min(first[0] + i, shape[0] - 1), std::min(first[1] + j, shape[1] - 1),
                                          std::min(first[2] + k, shape[2] - 1));
        }
      }
    }
    return found;
  }

  static constexpr double kRounding = 1e-9;  ///< in voxels

  const double resolution_m;
  const Eigen::Vector3d low_m, high_m;
  const Options options;
  DynamicEDT3D transform;
  std::array<int, 3> shape{};
  Eigen::Vector3d low_centre_m;
  std::vector<bool> is_obstacle;
};

DistanceField::DistanceField(const OccupancyMap& map, const Eigen::Vector3d& low_world_m,
                             const Eigen::Vector3d& high_world_m, const Options& options)
    : impl_(std::make_unique<Impl>(map, low_world_m, high_world_m, options)) {}
DistanceField::~DistanceField() = default;
DistanceField::DistanceField(DistanceField&&) noexcept = default;

std::size_t DistanceField::update(const OccupancyMap& map) {
  return impl_->set(map.states_in(impl_->low_m, impl_->high_m, kVoxelsMax));
}

std::vector<float> DistanceField::distance_m(std::span<const double> points_world_m) const {
  std::vector<float> distances(points_world_m.size() / 3);
  for (std::size_t i = 0; i < distances.size(); ++i) {
    const Impl::Corners c = impl_->corners(&points_world_m[3 * i]);
    double sum = c.inside ? 0.0 : kNan;
    for (int corner = 0; c.inside && corner < 8; ++corner) {
      const int x = corner & 1, y = corner >> 1 & 1, z = corner >> 2;
      const double weight =
          (x ? c.along[0] : 1 - c.along[0]) * (y ? c.along[1] : 1 - c.along[1]) * (z ? c.along[2] : 1 - c.along[2]);
      sum += weight * c.distances_m[x][y][z];
    }
    distances[i] = static_cast<float>(sum);
  }
  return distances;
}

std::vector<double> DistanceField::gradient(std::span<const double> points_world_m) const {
  std::vector<double> gradients(points_world_m.size(), kNan);
  for (std::size_t i = 0; i < points_world_m.size() / 3; ++i) {
    const Impl::Corners c = impl_->corners(&points_world_m[3 * i]);
    if (!c.inside) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t second = (axis + 1) % 3, third = (axis + 2) % 3;
      double sum = 0;
      for (int corner = 0; corner < 8; ++corner) {
        const int index[3] = {corner & 1, corner >> 1 & 1, corner >> 2};
        const double weight = (index[second] ? c.along[second] : 1 - c.along[second]) *
                              (index[third] ? c.along[third] : 1 - c.along[third]);
        sum += (index[axis] ? weight : -weight) * c.distances_m[index[0]][index[1]][index[2]];
      }
      gradients[3 * i + axis] = sum / impl_->resolution_m;
    }
  }
  return gradients;
}

std::vector<float> DistanceField::grid() const {
  std::vector<float> all;
  all.reserve(impl_->is_obstacle.size());
  for (int x = 0; x < impl_->shape[0]; ++x) {
    for (int y = 0; y < impl_->shape[1]; ++y) {
      for (int z = 0; z < impl_->shape[2]; ++z) all.push_back(static_cast<float>(impl_->at(x, y, z)));
    }
  }
  return all;
}

const std::array<int, 3>& DistanceField::shape() const { return impl_->shape; }
const Eigen::Vector3d& DistanceField::low_centre_world_m() const { return impl_->low_centre_m; }

}  // namespace uwsim
