#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "uwsim/mapping/octree_file.h"

namespace uwsim {

struct MapStatistics {
  std::uint64_t occupied_voxels;  ///< counted at the finest level: a pruned leaf is as many voxels as it covers
  std::uint64_t free_voxels;
  std::size_t nodes;         ///< of the pruned tree
  std::size_t memory_bytes;  ///< by OctoMap's own reckoning, which leaves out the allocator's share
};

/// A probabilistic occupancy map: Debian's octomap::OcTree (Hornung et al. 2013, Autonomous Robots 34(3)) with
/// OctoMap's default sensor model: hit 0.7, miss 0.4, clamped to [0.1192, 0.971], occupied from 0.5 on.
///
/// OctoMap's cube reaches 2^15 voxels from its origin along each axis (+-6.5 km at 0.2 m) and `origin_world_m` puts
/// that origin where the survey is: the tree and its files hold world minus origin, and the caller keeps the origin.
/// What goes in is rounded to float32 there.
///
/// The bytes of a map depend on the scans and their order alone, not on what was asked or written in between. Safe to
/// use from several threads: calls wait for each other.
class OccupancyMap {
 public:
  /// resolution_m: edge of a voxel, in [0.001, 1000]. Throws InvalidValue.
  explicit OccupancyMap(double resolution_m, const Eigen::Vector3d& origin_world_m = Eigen::Vector3d::Zero());
  /// A map from a .bt or .ot file, told apart by its first line. A .bt knows only occupied or free: its voxels come
  /// back at the clamping limits. Throws FileError if it cannot be read, InvalidValue if it is no sound map.
  static OccupancyMap read(const std::string& path, const Eigen::Vector3d& origin_world_m = Eigen::Vector3d::Zero());
  /// The same from memory; `name` stands for the path in messages.
  static OccupancyMap from_bytes(std::string_view bytes, std::string_view name,
                                 const Eigen::Vector3d& origin_world_m = Eigen::Vector3d::Zero());
  ~OccupancyMap();
  OccupancyMap(OccupancyMap&&) noexcept;
  OccupancyMap& operator=(OccupancyMap&&) noexcept;

  double resolution_m() const;
  Eigen::Vector3d origin_world_m() const;

  /// One ping: every voxel between the origin and a point is seen free once, every voxel that holds a point occupied
  /// once, occupied winning (OctoMap's insertPointCloud). Of a point farther than max_range_m (infinity: no limit) only
  /// the free part up to there counts. points_world_m: x, y, z by rows. Points that are not finite are no echo and are
  /// skipped. Throws InvalidValue, and inserts nothing, if the origin is not finite or a point or the origin lies
  /// outside OctoMap's cube.
  void insert_scan(std::span<const float> points_world_m, const Eigen::Vector3d& origin_world_m, double max_range_m);

  /// Centres, x, y, z by rows, of the voxels of the finest level, pruned leaves expanded, in Morton order (z, y, x bits
  /// from the highest level down). Throws InvalidValue past 100 million of them.
  std::vector<double> occupied_voxels_world_m() const;
  std::vector<double> free_voxels_world_m() const;

  MapStatistics statistics() const;

  /// 1 occupied, 0 free, -1 unknown or outside the cube; one a point. Throws InvalidValue on points that are not
  /// finite.
  std::vector<std::int8_t> state_at(std::span<const double> points_world_m) const;

  /// The file as bytes. The map stays as it is: a .bt written in mid-survey does not round the live log-odds off.
  /// A .bt is pruned as far as it goes, so that equal voxels give equal bytes.
  std::string to_bytes(MapFormat format) const;
  /// Atomically; throws FileError.
  void write(const std::string& path, MapFormat format) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace uwsim
