#include <algorithm>
#include <cmath>
#include <string>

#include "uwsim/core/check.h"
#include "uwsim/mapping/map_ray.h"
#include "uwsim/mapping/occupancy_map_impl.h"

namespace uwsim {
namespace {

constexpr double kRadiusVoxelsMax = 256;
constexpr double kViewVoxelsMax = 400;

void require_rows(std::span<const double> points, const char* path) {
  require(points.size() % 3 == 0, std::string(path) + ".size", points.size(), "must be rows of x, y, z");
  for (const double x : points) require(std::isfinite(x), path, x, "must be finite");
}

void require_poses(std::span<const BodyPose> poses) {
  for (const BodyPose& pose : poses) {
    require(pose.position_world_m.allFinite(), "positions_world_m", pose.position_world_m.transpose(),
            "must be finite");
    require(std::abs(pose.world_from_body.norm() - 1.0) < 1e-6, "orientations_xyzw",
            pose.world_from_body.coeffs().transpose(), "must be of length 1");
  }
}

/// The voxels around a sensor, one bit each, so that each voxel is counted only once.
class SeenVoxels {
 public:
  explicit SeenVoxels(int reach) : reach_(reach), across_(2 * std::size_t(reach) + 1) {
    bits_.resize((across_ * across_ * across_ + 63) / 64);
  }
  void start_at(const VoxelKey& middle) {
    middle_ = middle;
    std::fill(bits_.begin(), bits_.end(), 0);
  }
  /// Returns true if the voxel is seen for the first time.
  bool add(const VoxelKey& key) {
    std::size_t index = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      index = index * across_ + static_cast<std::size_t>(key[axis] - middle_[axis] + reach_);
    }
    const std::uint64_t bit = std::uint64_t{1} << (index & 63);
    const bool is_new = (bits_[index / 64] & bit) == 0;
    bits_[index / 64] |= bit;
    return is_new;
  }

 private:
  const int reach_;
  const std::size_t across_;
  VoxelKey middle_{};
  std::vector<std::uint64_t> bits_;
};

/// Returns directions within a pyramid, such that adjacent rays are at most `spacing_rad` apart.
std::vector<Eigen::Vector3d> directions_of(const ViewPyramid& view, double spacing_rad) {
  const double angles[2] = {view.horizontal_rad, view.vertical_rad};
  int intervals[2];
  for (int i = 0; i < 2; ++i) intervals[i] = std::max(1, static_cast<int>(std::ceil(angles[i] / spacing_rad)));
  const auto tangent = [&](int i, int k) { return std::tan(angles[i] * (double(k) / intervals[i] - 0.5)); };
  std::vector<Eigen::Vector3d> directions;
  for (int column = 0; column <= intervals[0]; ++column) {
    for (int row = 0; row <= intervals[1]; ++row) {
      directions.push_back(Eigen::Vector3d(1, tangent(0, column), tangent(1, row)).normalized());
    }
  }
  return directions;
}

}  // namespace

StateGrid OccupancyMap::states_in(const Eigen::Vector3d& low_world_m, const Eigen::Vector3d& high_world_m,
                                  std::size_t voxels_max) const {
  StateGrid grid;
  const std::optional<KeyBox> box = impl_->keys_in(low_world_m, high_world_m);
  if (!box) return grid;
  double voxels = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    grid.shape[axis] = box->high[axis] - box->low[axis] + 1;
    grid.low_centre_world_m[Eigen::Index(axis)] = impl_->centre_world_m(box->low, 0, axis);
    voxels *= grid.shape[axis];
  }
  require(voxels <= static_cast<double>(voxels_max), "box.voxels", voxels,
          "must be at most " + std::to_string(voxels_max));
  grid.states.assign(static_cast<std::size_t>(voxels), -1);
  const std::scoped_lock lock(impl_->mutex);
  impl_->engine->for_each_leaf_in(*box, [&](const VoxelKey& corner, int levels, float log_odds) {
    std::array<int, 3> first, last;  // the leaf's part of the box
    for (std::size_t axis = 0; axis < 3; ++axis) {
      first[axis] = std::max(corner[axis] - box->low[axis], 0);
      last[axis] = std::min(corner[axis] + (1 << levels) - box->low[axis], grid.shape[axis]);
    }
    for (int x = first[0]; x < last[0]; ++x) {
      for (int y = first[1]; y < last[1]; ++y) {
        const std::size_t row =
            (static_cast<std::size_t>(x) * std::size_t(grid.shape[1]) + std::size_t(y)) * std::size_t(grid.shape[2]);
        for (int z = first[2]; z < last[2]; ++z) grid.states[row + std::size_t(z)] = is_occupied(log_odds);
      }
    }
  });
  return grid;
}

std::vector<std::uint8_t> OccupancyMap::spheres_blocked(std::span<const double> centres_world_m, double radius_m,
                                                        bool unknown_blocks) const {
  require_rows(centres_world_m, "centres_world_m");
  const double edge_m = impl_->resolution_m;
  require(radius_m >= 0 && radius_m <= kRadiusVoxelsMax * edge_m, "radius_m", radius_m,
          "must be from 0 to 256 voxels of " + std::to_string(edge_m) + " m");
  std::vector<std::uint8_t> blocked(centres_world_m.size() / 3);
  const std::scoped_lock lock(impl_->mutex);
  const auto blocks = [&](const VoxelKey& key) {
    const bool inside = std::all_of(key.begin(), key.end(), [](int k) { return k >= 0 && k < 2 * kHalfExtent; });
    const std::optional<float> log_odds = inside ? impl_->engine->log_odds_at(key) : std::nullopt;
    return log_odds ? is_occupied(*log_odds) : unknown_blocks;
  };
  for (std::size_t i = 0; i < blocked.size(); ++i) {
    const Eigen::Vector3d centre_m = Eigen::Vector3d(&centres_world_m[3 * i]) - impl_->origin_world_m;
    VoxelKey low, high;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto key = [&](double at) {  // the cube's neighbours are all unknown
        return static_cast<int>(std::clamp(impl_->cell(at), -kHalfExtent - 1.0, double(kHalfExtent))) + kHalfExtent;
      };
      low[axis] = key(centre_m[Eigen::Index(axis)] - radius_m);
      high[axis] = key(centre_m[Eigen::Index(axis)] + radius_m);
    }
    const auto beyond_m = [&](int k, std::size_t axis) {  // from the centre to the voxel, along one axis
      const double face_m = (k - kHalfExtent) * edge_m, at = centre_m[Eigen::Index(axis)];
      return std::max({face_m - at, at - face_m - edge_m, 0.0});
    };
    for (VoxelKey key{low[0], 0, 0}; key[0] <= high[0] && !blocked[i]; ++key[0]) {
      const double x_m = beyond_m(key[0], 0);
      for (key[1] = low[1]; key[1] <= high[1] && !blocked[i]; ++key[1]) {
        const double y_m = beyond_m(key[1], 1);
        for (key[2] = low[2]; key[2] <= high[2] && !blocked[i]; ++key[2]) {
          const double z_m = beyond_m(key[2], 2);
          blocked[i] = x_m * x_m + y_m * y_m + z_m * z_m <= radius_m * radius_m && blocks(key);
        }
      }
    }
  }
  return blocked;
}

std::vector<std::uint8_t> OccupancyMap::bodies_blocked(std::span<const double> points_body_m,
                                                       std::span<const BodyPose> poses, bool unknown_blocks) const {
  require_rows(points_body_m, "points_body_m");
  require_poses(poses);
  std::vector<std::uint8_t> blocked(poses.size());
  const std::scoped_lock lock(impl_->mutex);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Eigen::Matrix3d turn = poses[i].world_from_body.toRotationMatrix();
    for (std::size_t k = 0; k < points_body_m.size() && !blocked[i]; k += 3) {
      const Eigen::Vector3d point = poses[i].position_world_m + turn * Eigen::Vector3d(&points_body_m[k]);
      const std::optional<VoxelKey> key = impl_->key_at(point.data());
      const std::optional<float> log_odds = key ? impl_->engine->log_odds_at(*key) : std::nullopt;
      blocked[i] = log_odds ? is_occupied(*log_odds) : unknown_blocks;
    }
  }
  return blocked;
}

std::vector<double> OccupancyMap::unknown_in_view_m3(std::span<const BodyPose> poses, const ViewPyramid& view) const {
  require_poses(poses);
  for (const double angle : {view.horizontal_rad, view.vertical_rad}) {
    require(angle > 0 && angle < M_PI, "field_of_view", angle, "must be in (0, pi) rad");
  }
  const double edge_m = impl_->resolution_m;
  require(view.range_m >= edge_m && view.range_m <= kViewVoxelsMax * edge_m, "range_m", view.range_m,
          "must be from 1 to 400 voxels of " + std::to_string(edge_m) + " m");
  const std::vector<Eigen::Vector3d> directions = directions_of(view, edge_m / view.range_m);
  SeenVoxels seen(static_cast<int>(std::ceil(view.range_m / edge_m)) + 2);
  std::vector<double> volumes_m3;
  volumes_m3.reserve(poses.size());
  const std::scoped_lock lock(impl_->mutex);
  for (const BodyPose& pose : poses) {
    const Eigen::Vector3f origin_m = impl_->tree_m(pose.position_world_m);
    impl_->require_in_cube(origin_m, "positions_world_m");
    seen.start_at(*impl_->key_at(pose.position_world_m.data()));
    const Eigen::Matrix3d turn = pose.world_from_body.toRotationMatrix();
    std::size_t unknown = 0;
    for (const Eigen::Vector3d& direction : directions) {
      follow_map_ray(edge_m, origin_m, (turn * direction).cast<float>(), view.range_m, [&](const VoxelKey& key) {
        const std::optional<float> log_odds = impl_->engine->log_odds_at(key);
        if (!log_odds) unknown += seen.add(key);
        return !log_odds || !is_occupied(*log_odds);
      });
    }
    volumes_m3.push_back(static_cast<double>(unknown) * edge_m * edge_m * edge_m);
  }
  return volumes_m3;
}

}  // namespace uwsim
