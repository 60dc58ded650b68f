#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>

#include "uwsim/mapping/octree_file.h"

namespace uwsim {

class AtomicFile;

/// Probabilities of OctoMap's sensor model, with its defaults. Log-odds are floats, reckoned as there.
struct OccupancyModel {
  double hit = 0.7;              ///< of a voxel that holds a point, in [0.5, 1)
  double miss = 0.4;             ///< of a voxel that a ray goes through, in (0, 0.5]
  double clamping_min = 0.1192;  ///< limits of what scans may make of a voxel
  double clamping_max = 0.971;

  static float log_odds(double probability);
  /// A voxel is occupied from a probability of 0.5 on.
  static bool is_occupied(float log_odds) { return log_odds >= 0; }
  /// Throws InvalidValue that names the value.
  void check() const;
};

/// One ping: points in the world, x, y, z by rows, of which those that are not finite are skipped; the origin of its
/// rays in the frame of the tree.
struct Scan {
  std::span<const float> points_world_m;
  Eigen::Vector3f origin_m;
};

/// The tree of a file: what follows its header.
struct TreeBytes {
  std::string body;
  std::uint64_t nodes = 0;
};

/// A voxel's key, or that of a leaf's lowest voxel: voxels from the corner of the cube, 0 to 65,535 an axis.
using VoxelKey = std::array<int, 3>;

/// Voxels from `low` to `high`, both among them.
struct KeyBox {
  VoxelKey low, high;

  /// Whether a cube of 2^levels voxels has any of them.
  bool meets(const VoxelKey& corner, int levels) const;
};

/// The 64 x 64 x 64 voxels of one chunk, by the Morton code of its key (a voxel's, less six bits an axis).
KeyBox chunk_box(std::uint32_t chunk);

/// Chunks in which a voxel may have become another.
struct ChangedChunks {
  bool all = false;
  std::set<std::uint32_t> codes;

  /// A cube of 2^levels voxels.
  void add(const VoxelKey& corner, int levels);
};

/// What OccupancyMap is made of. Callers check what goes in, and let one thread in at a time.
class MapEngine {
 public:
  /// leaf(key, levels, log_odds): `levels` above the finest, `key` that of its lowest corner.
  using LeafVisitor = std::function<void(const VoxelKey&, int, float)>;

  virtual ~MapEngine() = default;

  /// In their order. max_range_m: negative for no limit.
  virtual void insert(std::span<const Scan> scans, double max_range_m, int threads) = 0;
  /// Into an empty map; the body has been proved to be sound.
  virtual void load(MapFormat format, std::string_view body) = 0;

  /// Adds log-odds to each voxel of a cube of 2^levels voxels, on its own lattice, as OctoMap's updateNodeLogOdds does:
  /// unknown is 0, the sum is clamped. finish_adding() comes after the last.
  virtual void add(const VoxelKey& corner, int levels, float log_odds) = 0;
  virtual void finish_adding() = 0;
  /// For later scans: the voxels stay as they are.
  virtual void set_model(const OccupancyModel& model) = 0;

  /// What may have changed since the last call; all at the first one, from which on it is recorded.
  virtual ChangedChunks take_changed() = 0;

  virtual std::optional<float> log_odds_at(const VoxelKey& key) const = 0;
  /// In Morton order; how far equal voxels are one leaf is the engine's business.
  virtual void for_each_leaf(const LeafVisitor& leaf) const = 0;
  /// Those that have voxels of the box.
  virtual void for_each_leaf_in(const KeyBox& box, const LeafVisitor& leaf) const = 0;
  /// All the log-odds, pruned, inner nodes the greatest of their children: an .ot.
  virtual TreeBytes full_tree() const = 0;
  /// Occupied or free alone, as OctoMap's writeBinary leaves it, written by an octomap::OcTree: a .bt.
  virtual TreeBytes binary_tree() const = 0;
  /// The file of either tree, header and all.
  virtual void write_tree(MapFormat format, AtomicFile& file) const = 0;
  /// Of the pruned tree.
  virtual std::uint64_t nodes() const = 0;
  virtual std::size_t memory_bytes() const = 0;
  /// Parts of the map that left memory so far.
  virtual std::uint64_t evictions() const { return 0; }
};

}  // namespace uwsim
