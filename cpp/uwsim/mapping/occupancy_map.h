#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "uwsim/core/instruction_set.h"
#include "uwsim/mapping/occupancy_model.h"
#include "uwsim/mapping/octree_file.h"

namespace octomap {
class OcTree;
}

namespace uwsim {

/// The data structures available for a map. From the same scans, both produce the same bytes of .bt and .ot files.
enum class MapEngineKind {
  octomap,  ///< Debian's octomap::OcTree and its insertPointCloud; the reference
  bricks,   ///< uwsim's own engine, which is much faster; see bricks/README.md
};

/// How to treat points outside OctoMap's cube. If a scan's origin is outside, all its points count as outside.
enum class OnOutside {
  refuse,  ///< throw InvalidValue and insert nothing
  count,   ///< discard and count them: MapStatistics::outside_points
};

struct MapOptions {
  MapEngineKind engine = MapEngineKind::bricks;
  OccupancyModel model;
  InstructionSet instruction_set = InstructionSet::best;  ///< for the kernels of `bricks`; does not affect the bytes
  OnOutside on_outside = OnOutside::refuse;
};

struct MapStatistics {
  std::uint64_t occupied_voxels;  ///< at the finest level: a pruned leaf counts as many voxels as it covers
  std::uint64_t free_voxels;
  std::size_t nodes;  ///< of the pruned tree
  /// Octomap: as OctoMap reports it, excluding the allocator's overhead; bricks: all memory of the map
  std::size_t memory_bytes;
  std::uint64_t outside_points;  ///< discarded so far, with OnOutside::count
};

/// The box around the known voxels of a map.
struct MapBounds {
  Eigen::Vector3d low_world_m, high_world_m;
};

/// Cubes of a map, in columns.
struct MapCubes {
  std::vector<double> centres_world_m;  ///< rows of x, y, z
  std::vector<double> edges_m;
  std::vector<float> log_odds;
};

/// The states of all voxels of a box: 1 occupied, 0 free, -1 unknown; z is the innermost index.
struct StateGrid {
  std::vector<std::int8_t> states;
  std::array<int, 3> shape{};
  Eigen::Vector3d low_centre_world_m = Eigen::Vector3d::Zero();  ///< the centre of the voxel with the lowest indices
};

/// A pose of a body: the position of its origin, and its rotation to the world.
struct BodyPose {
  Eigen::Vector3d position_world_m;
  Eigen::Quaterniond world_from_body;
};

/// A pyramid with its tip at a sensor, which looks along x, with y to port and z up.
struct ViewPyramid {
  double horizontal_rad, vertical_rad;  ///< the whole angles of view, in (0, pi)
  double range_m;                       ///< from the tip
};

/// A probabilistic occupancy map: OctoMap's octree (Hornung et al. 2013, Autonomous Robots 34(3)) with OctoMap's sensor
/// model (log_odds.h).
///
/// OctoMap's cube extends 2^15 voxels from its origin along each axis (+-6.5 km at 0.2 m). `origin_world_m` moves that
/// origin to the survey area. The tree and its files store positions relative to the origin but not the origin itself,
/// so the caller must keep track of it. Points are rounded to float32 in the tree's frame.
///
/// The bytes of a map depend only on the scans and their order, not on queries made or files written in between.
/// Thread-safe: concurrent calls are serialised.
class OccupancyMap {
 public:
  /// resolution_m: edge of a voxel, in [0.001, 1000]. Throws InvalidValue.
  explicit OccupancyMap(double resolution_m, const Eigen::Vector3d& origin_world_m = Eigen::Vector3d::Zero(),
                        const MapOptions& options = {});
  /// Reads a .bt or .ot file; the first line identifies the format. A .bt only distinguishes occupied and free, so its
  /// voxels are set to the clamping limits. Throws FileError if the file cannot be read, InvalidValue if it is not a
  /// valid map, or if the map has no memory limit and may need more than half of this machine's memory.
  static OccupancyMap read(const std::string& path, const Eigen::Vector3d& origin_world_m = Eigen::Vector3d::Zero(),
                           const MapOptions& options = {});
  /// Reads a map from memory; `name` replaces the path in messages.
  static OccupancyMap from_bytes(std::string_view bytes, std::string_view name,
                                 const Eigen::Vector3d& origin_world_m = Eigen::Vector3d::Zero(),
                                 const MapOptions& options = {});
  ~OccupancyMap();
  OccupancyMap(OccupancyMap&&) noexcept;
  OccupancyMap& operator=(OccupancyMap&&) noexcept;

  double resolution_m() const;
  Eigen::Vector3d origin_world_m() const;
  MapEngineKind engine() const;

  /// Inserts one ping like OctoMap's insertPointCloud: a voxel that contains a point gets one hit, any other voxel
  /// between the origin and a point gets one miss. A point beyond max_range_m (infinity: no limit; at least a
  /// nanometre) causes misses up to that range and no hit. points_world_m: rows of x, y, z; non-finite points mean no
  /// echo and are skipped. If the origin is non-finite, or the origin or a point lies outside OctoMap's cube, throws
  /// InvalidValue without inserting anything.
  void insert_scan(std::span<const float> points_world_m, const Eigen::Vector3d& origin_world_m, double max_range_m);

  /// Inserts several pings in order, which is faster than one at a time. counts: number of points in each ping;
  /// points_world_m: the points of all pings; origins_world_m: x, y, z of each ping. threads: for engine `bricks`; does
  /// not affect the bytes. Throws like insert_scan(), in which case no ping is inserted.
  void insert_scans(std::span<const float> points_world_m, std::span<const std::int64_t> counts,
                    std::span<const double> origins_world_m, double max_range_m, int threads);

  /// Centres of the occupied voxels at the finest level, rows of x, y, z, in Morton order (z, y, x bits from the
  /// highest level down). Throws InvalidValue if there are more than 100 million.
  std::vector<double> occupied_voxels_world_m() const;
  std::vector<double> free_voxels_world_m() const;

  MapStatistics statistics() const;
  VoxelCounts count() const;
  /// The box around the known (occupied or free) voxels; nullopt for an empty map.
  std::optional<MapBounds> bounds() const;

  // Defined in occupancy_map_queries.cpp:

  /// The state of the voxel at each point: 1 occupied, 0 free, -1 unknown or outside the cube. Throws InvalidValue for
  /// non-finite points.
  std::vector<std::int8_t> state_at(std::span<const double> points_world_m) const;
  /// The log-odds of being occupied at each point; NaN where state_at() is -1.
  std::vector<float> log_odds_at(std::span<const double> points_world_m) const;

  /// The leaves of the pruned tree, in Morton order.
  MapCubes leaves() const;
  /// The cubes at a given depth of the tree, from 1 to 16 (the finest), that contain known voxels, in Morton order. A
  /// cube's log-odds are the maximum of those inside it, as in OctoMap's inner nodes. Throws InvalidValue if there are
  /// more than 100 million.
  MapCubes cells(int depth) const;
  /// The known voxels at the finest level whose centres lie in a box, including its faces, in Morton order. Throws
  /// InvalidValue if there are more than 100 million.
  MapCubes voxels_in(const Eigen::Vector3d& low_world_m, const Eigen::Vector3d& high_world_m) const;

  struct Casts {
    std::vector<std::int8_t> ends;              ///< 1 occupied, 0 maximum range or the cube's edge, -1 unknown
    std::vector<double> voxel_centres_world_m;  ///< centre of the last voxel that each ray reached
  };
  /// Casts rays, given as rows of x, y, z, like octomap::OcTree::castRay, in float32. max_range_m: measured to a
  /// voxel's centre; infinity for no limit. Throws InvalidValue for an origin outside the cube or a direction of length
  /// zero.
  Casts cast_rays(std::span<const double> origins_world_m, std::span<const double> directions_world,
                  bool ignore_unknown, double max_range_m) const;

  // For planners, defined in occupancy_map_planning.cpp:

  /// The states of the voxels whose centres lie in a box, including its faces. Throws InvalidValue if there are more
  /// than `voxels_max`.
  StateGrid states_in(const Eigen::Vector3d& low_world_m, const Eigen::Vector3d& high_world_m,
                      std::size_t voxels_max) const;
  /// Returns 1 for each sphere that touches voxels that are occupied or, with `unknown_blocks`, unknown.
  /// centres_world_m: rows of x, y, z. radius_m: at most 256 voxels. Throws InvalidValue.
  std::vector<std::uint8_t> spheres_blocked(std::span<const double> centres_world_m, double radius_m,
                                            bool unknown_blocks) const;
  /// Returns 1 for each pose in which points of a body lie in such voxels. points_body_m: rows of x, y, z. Throws
  /// InvalidValue.
  std::vector<std::uint8_t> bodies_blocked(std::span<const double> points_body_m, std::span<const BodyPose> poses,
                                           bool unknown_blocks) const;
  /// The volume [m^3] of the unknown voxels that a sensor in each pose would see: those that lie on a ray within the
  /// pyramid before the first occupied voxel. Adjacent rays are at most a voxel apart at the pyramid's range, which is
  /// at most 400 voxels. Throws InvalidValue, including for a position outside the cube.
  std::vector<double> unknown_in_view_m3(std::span<const BodyPose> poses, const ViewPyramid& view) const;

  struct Changes {
    std::vector<double> voxel_centres_world_m;
    std::vector<std::int8_t> states;  ///< 1 occupied, 0 free, -1 unknown
  };
  /// Returns the voxels whose state has changed since the last call, in Morton order; on the first call, all known
  /// voxels. Throws InvalidValue if there are more than 100 million; the next call then reports them.
  Changes changed_voxels();

  struct OccupancyChanges {
    std::vector<std::int16_t> cells;     ///< rows of x, y, z in voxels from the origin
    std::vector<std::uint8_t> occupied;  ///< 1: became occupied, 0: is no longer occupied
  };
  /// Returns the voxels that became occupied, or are no longer occupied, since the last call, in Morton order; on the
  /// first call, all occupied voxels. Throws InvalidValue if there are more than 100 million; the next call then
  /// reports them.
  OccupancyChanges changed_occupancy();

  /// Adds another map's log-odds, voxel by voxel: an unknown voxel counts as 0, and the sum is clamped to this map's
  /// limits. The other map's origin must be a whole number of voxels from this map's along each axis. If it is not, or
  /// if the other map has a different resolution, is this map itself, or extends outside the cube, throws
  /// InvalidValue without changing anything.
  void merge(const OccupancyMap& other);

  OccupancyModel model() const;
  /// Sets the sensor model for later scans; a voxel keeps its value until a scan changes it. Throws InvalidValue.
  void set_model(const OccupancyModel& model);

  /// Returns the bytes of a file. The map does not change: writing a .bt during a survey does not reset the log-odds to
  /// the clamping limits. A .bt is written by octomap::OcTree's writeBinary or, if the map is large, by uwsim's own
  /// writer, with the same bytes.
  std::string to_bytes(MapFormat format) const;
  /// Writes a file atomically (AtomicFile). Throws FileError.
  void write(const std::string& path, MapFormat format) const;

  /// A copy as OctoMap's own tree, with all log-odds.
  std::shared_ptr<octomap::OcTree> octree() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace uwsim
