#pragma once

#include <atomic>
#include <cmath>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "uwsim/mapping/map_changes.h"
#include "uwsim/mapping/map_engine.h"
#include "uwsim/mapping/map_queries.h"
#include "uwsim/mapping/occupancy_map.h"

/// Inside OccupancyMap: for the files of its members alone.
namespace uwsim {

struct OccupancyMap::Impl {
  Impl(double resolution, const Eigen::Vector3d& origin, const MapOptions& what)
      : resolution_m(resolution),
        origin_world_m(origin),
        options(what),
        engine(make_engine(resolution, origin, what)) {}

  static std::unique_ptr<MapEngine> make_engine(double resolution_m, const Eigen::Vector3d& origin_world_m,
                                                const MapOptions& options);

  /// Voxels from OctoMap's origin along an axis, as OctoMap itself reckons it.
  double cell(double tree_m) const { return std::floor(1.0 / resolution_m * tree_m); }

  /// Within the cube, less its outermost voxels: a ray along the very edge could step over it.
  bool in_cube(float tree_m) const { return std::abs(cell(tree_m) + 0.5) < kHalfExtent - 1; }

  bool in_cube(const Eigen::Vector3f& tree_m) const {
    return in_cube(tree_m.x()) && in_cube(tree_m.y()) && in_cube(tree_m.z());
  }
  void require_in_cube(const Eigen::Vector3f& tree_m, const char* path) const;

  Eigen::Vector3f tree_m(const Eigen::Vector3d& world_m) const { return (world_m - origin_world_m).cast<float>(); }

  Scan checked(std::span<const float> points_world_m, const Eigen::Vector3d& scan_origin_world_m,
               double max_range_m) const;
  void check_points(const Scan& scan, double max_range_m) const;
  void insert(std::span<const Scan> scans, double max_range_m, int threads);
  /// What of a scan can be inserted, and how many points cannot, for being outside; they must be counted, not refused.
  std::pair<std::vector<float>, std::uint64_t> inside(std::span<const float> points_world_m,
                                                      const Eigen::Vector3d& scan_origin_world_m) const;

  /// Key of the voxel that holds a point; nothing outside the cube.
  std::optional<VoxelKey> key_at(const double* point_world_m) const;
  /// Centre of a cube of 2^levels voxels, in the world, along an axis.
  double centre_world_m(const VoxelKey& corner, int levels, std::size_t axis) const {
    return (corner[axis] - kHalfExtent + 0.5 * (1 << levels)) * resolution_m + origin_world_m[Eigen::Index(axis)];
  }

  std::uint64_t count(bool occupied) const;
  std::vector<double> voxels_world_m(bool occupied) const;

  const double resolution_m;
  const Eigen::Vector3d origin_world_m;
  MapOptions options;
  const std::unique_ptr<MapEngine> engine;
  MapChanges changes;
  std::uint64_t outside_points = 0;  ///< that were counted, not inserted
  mutable std::mutex mutex;
};

}  // namespace uwsim
