#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "uwsim/mapping/map_engine.h"
#include "uwsim/mapping/octree_file.h"
#include "uwsim/mapping/scan_kernels.h"

namespace octomap {
class OcTree;
}

namespace uwsim {

/// What a map is made of. Both give the same bytes, .bt and .ot, after the same scans.
enum class MapEngineKind {
  octomap,  ///< Debian's octomap::OcTree and its insertPointCloud: the reference
  bricks,   ///< ours, much faster
};

/// What happens to points, and to whole scans by their origin, that lie outside OctoMap's cube.
enum class OnOutside {
  refuse,  ///< InvalidValue, and nothing is inserted
  count,   ///< they are left out and counted: MapStatistics::outside_points
};

struct MapOptions {
  MapEngineKind engine = MapEngineKind::bricks;
  OccupancyModel model;
  InstructionSet instruction_set = InstructionSet::best;  ///< of the bricks; the bytes do not depend on it
  OnOutside on_outside = OnOutside::refuse;
  /// What the voxels may take of memory, near enough: one batch of scans comes on top, and the reserves of memory.
  /// Parts of the map that were not used for longest go to a file without a name in `spill_folder` (empty: the
  /// system's), and come back when they are used. 0: no limit. Only of the bricks.
  std::size_t memory_limit_bytes = 0;
  std::string spill_folder = {};
};

struct MapStatistics {
  std::uint64_t occupied_voxels;  ///< counted at the finest level: a pruned leaf is as many voxels as it covers
  std::uint64_t free_voxels;
  std::size_t nodes;             ///< of the pruned tree
  std::size_t memory_bytes;      ///< octomap: by its own reckoning, which leaves out the allocator's share; bricks: all
  std::uint64_t outside_points;  ///< left out so far, with OnOutside::count
  std::uint64_t evictions;       ///< parts of the map that left memory so far
};

/// Cubes of a map, by columns.
struct MapCubes {
  std::vector<double> centres_world_m;  ///< x, y, z by rows
  std::vector<double> edges_m;
  std::vector<float> log_odds;
};

/// A probabilistic occupancy map: OctoMap's octree (Hornung et al. 2013, Autonomous Robots 34(3)) with OctoMap's sensor
/// model.
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
  explicit OccupancyMap(double resolution_m, const Eigen::Vector3d& origin_world_m = Eigen::Vector3d::Zero(),
                        const MapOptions& options = {});
  /// A map from a .bt or .ot file, told apart by its first line. A .bt knows only occupied or free: its voxels come
  /// back at the clamping limits. Throws FileError if it cannot be read, InvalidValue if it is no sound map, or one
  /// that may need more than half of this machine's memory and has no limit.
  static OccupancyMap read(const std::string& path, const Eigen::Vector3d& origin_world_m = Eigen::Vector3d::Zero(),
                           const MapOptions& options = {});
  /// The same from memory; `name` stands for the path in messages.
  static OccupancyMap from_bytes(std::string_view bytes, std::string_view name,
                                 const Eigen::Vector3d& origin_world_m = Eigen::Vector3d::Zero(),
                                 const MapOptions& options = {});
  ~OccupancyMap();
  OccupancyMap(OccupancyMap&&) noexcept;
  OccupancyMap& operator=(OccupancyMap&&) noexcept;

  double resolution_m() const;
  Eigen::Vector3d origin_world_m() const;
  MapEngineKind engine() const;

  /// One ping: every voxel between the origin and a point is seen free once, every voxel that holds a point occupied
  /// once, occupied winning (OctoMap's insertPointCloud). Of a point farther than max_range_m (infinity: no limit; at
  /// least a nanometre) only the free part up to there counts. points_world_m: x, y, z by rows. Points that are not
  /// finite are no echo and are skipped. Throws InvalidValue, and inserts nothing, if the origin is not finite or a
  /// point or the origin lies outside OctoMap's cube.
  void insert_scan(std::span<const float> points_world_m, const Eigen::Vector3d& origin_world_m, double max_range_m);

  /// Pings one after the other, in one go, which is faster. counts: points of each; points_world_m: all of them;
  /// origins_world_m: x, y, z of each. threads: of the bricks; the bytes do not depend on it. Throws as above, and
  /// inserts nothing, if any is wrong.
  void insert_scans(std::span<const float> points_world_m, std::span<const std::int64_t> counts,
                    std::span<const double> origins_world_m, double max_range_m, int threads);

  /// Centres, x, y, z by rows, of the voxels of the finest level, pruned leaves expanded, in Morton order (z, y, x bits
  /// from the highest level down). Throws InvalidValue past 100 million of them.
  std::vector<double> occupied_voxels_world_m() const;
  std::vector<double> free_voxels_world_m() const;

  MapStatistics statistics() const;

  // Defined in occupancy_map_queries.cpp:

  /// 1 occupied, 0 free, -1 unknown or outside the cube; one a point. Throws InvalidValue on points that are not
  /// finite.
  std::vector<std::int8_t> state_at(std::span<const double> points_world_m) const;
  /// Log-odds of being occupied, NaN where state_at is -1.
  std::vector<float> log_odds_at(std::span<const double> points_world_m) const;

  /// The leaves of the pruned tree, in Morton order.
  MapCubes leaves() const;
  /// Cubes at a depth of the tree, 1 to 16, the finest, of which something is known, in Morton order: the greatest of
  /// their log-odds, as in OctoMap's inner nodes. Throws InvalidValue past 100 million.
  MapCubes cells(int depth) const;
  /// Known voxels of the finest level whose centres lie in a box, both faces included, in Morton order. Throws
  /// InvalidValue past 100 million.
  MapCubes voxels_in(const Eigen::Vector3d& low_world_m, const Eigen::Vector3d& high_world_m) const;

  struct Casts {
    std::vector<std::int8_t> ends;              ///< 1 occupied, 0 its greatest range or the cube's edge, -1 unknown
    std::vector<double> voxel_centres_world_m;  ///< of the last voxel each ray came to
  };
  /// Rays, x, y, z by rows, as octomap::OcTree::castRay walks them, in float32. max_range_m: to a voxel's centre,
  /// infinity for no limit. Throws InvalidValue on an origin outside the cube and on a direction of no length.
  Casts cast_rays(std::span<const double> origins_world_m, std::span<const double> directions_world,
                  bool ignore_unknown, double max_range_m) const;

  struct Changes {
    std::vector<double> voxel_centres_world_m;
    std::vector<std::int8_t> states;  ///< 1 occupied, 0 free, -1 unknown
  };
  /// Voxels whose state is another than at the last call, in Morton order; at the first call, all that are known. A
  /// voxel that changed and changed back is not told. Throws InvalidValue past 100 million.
  Changes changed_voxels();

  /// Adds another map's log-odds, voxel by voxel: unknown is 0, the sum is clamped to this map's limits. The other may
  /// be about another origin, a whole number of voxels away. Throws InvalidValue, having changed nothing, if it is not,
  /// is of another resolution, is this map itself or reaches outside the cube.
  void merge(const OccupancyMap& other);

  OccupancyModel model() const;
  /// For later scans: voxels stay as they are until one changes them. Throws InvalidValue.
  void set_model(const OccupancyModel& model);

  /// The file as bytes. The map stays as it is: a .bt written in mid-survey does not round the live log-odds off.
  /// A .bt is written by an octomap::OcTree, the bytes those of its writeBinary; one of a map with a limit of memory by
  /// us, the same bytes.
  std::string to_bytes(MapFormat format) const;
  /// Atomically, as it is made: an .ot, and a .bt of a map with a limit, take a few megabytes of memory. Throws
  /// FileError.
  void write(const std::string& path, MapFormat format) const;

  /// A copy as OctoMap's own tree, with all its log-odds.
  std::shared_ptr<octomap::OcTree> octree() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace uwsim
