#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "uwsim/core/fork_safe_mutex.h"
#include "uwsim/mapping/map_changes.h"
#include "uwsim/mapping/map_engine.h"
#include "uwsim/mapping/occupancy_map.h"
#include "uwsim/mapping/occupied_changes.h"

/// Only for the files that define OccupancyMap's members (occupancy_map*.cpp).
namespace uwsim {

struct OccupancyMap::Impl {
  Impl(double resolution, const Eigen::Vector3d& origin, const MapOptions& chosen)
      : resolution_m(resolution),
        origin_world_m(origin),
        options(chosen),
        engine(make_engine(resolution, origin, chosen)) {}

  static std::unique_ptr<MapEngine> make_engine(double resolution_m, const Eigen::Vector3d& origin_world_m,
                                                const MapOptions& options);

  /// The number of voxels from OctoMap's origin along an axis, computed as in OctoMap.
  double cell(double tree_m) const { return std::floor(1.0 / resolution_m * tree_m); }

  /// Whether a coordinate is within the cube, excluding the outermost voxels, where a ray along the edge could step
  /// outside.
  bool in_cube(float tree_m) const { return std::abs(cell(tree_m) + 0.5) < kHalfExtent - 1; }

  bool in_cube(const Eigen::Vector3f& tree_m) const {
    return in_cube(tree_m.x()) && in_cube(tree_m.y()) && in_cube(tree_m.z());
  }
  void require_in_cube(const Eigen::Vector3f& tree_m, const char* path) const;

  Eigen::Vector3f tree_m(const Eigen::Vector3d& world_m) const { return (world_m - origin_world_m).cast<float>(); }

  // Defined in occupancy_map_insert.cpp:

  Scan checked_scan(std::span<const float> points_world_m, const Eigen::Vector3d& scan_origin_world_m,
                    double max_range_m) const;
  void check_points(const Scan& scan, double max_range_m) const;
  struct Clipped {
    std::vector<float> inside_world_m;  ///< the points inside the cube; empty if `outside` is 0
    std::uint64_t outside;              ///< the number of points outside: all of them if the scan's origin is outside
  };
  Clipped clip_to_cube(std::span<const float> points_world_m, const Eigen::Vector3d& scan_origin_world_m) const;

  /// The key of the voxel that contains a point; nullopt if the point is outside the cube.
  std::optional<VoxelKey> key_at(const double* point_world_m) const;
  /// The voxels whose centres lie in a box, including its faces; nullopt if there are none. Throws InvalidValue.
  std::optional<KeyBox> keys_in(const Eigen::Vector3d& low_world_m, const Eigen::Vector3d& high_world_m) const;
  /// The centre, along one axis, of a cube with an edge of 2^levels voxels.
  double centre_world_m(const VoxelKey& corner, int levels, std::size_t axis) const {
    return (corner[axis] - kHalfExtent + 0.5 * (1 << levels)) * resolution_m + origin_world_m[Eigen::Index(axis)];
  }

  /// Passes the chunks that may have changed to both lists of changes. Must be called before either list is read.
  void note_changes() {
    const ChangedChunks latest = engine->take_changed();
    changes.note(latest);
    occupied_changes.note(latest);
  }

  /// Calls visit(key) for each voxel that is occupied (or free), in Morton order.
  template <typename Visit>
  void for_each_voxel_that_is(bool occupied, const Visit& visit) const;
  std::vector<double> voxels_world_m(bool occupied) const;

  const double resolution_m;
  const Eigen::Vector3d origin_world_m;
  MapOptions options;
  const std::unique_ptr<MapEngine> engine;
  MapChanges changes;
  OccupiedChanges occupied_changes;
  std::uint64_t outside_points = 0;  ///< number discarded so far
  mutable ForkSafeMutex<std::mutex> mutex;
};

}  // namespace uwsim
