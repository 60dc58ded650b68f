#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "uwsim/mapping/changed_chunks.h"
#include "uwsim/mapping/log_odds.h"
#include "uwsim/mapping/occupancy_model.h"
#include "uwsim/mapping/octree_file.h"
#include "uwsim/mapping/voxel_key.h"

namespace uwsim {

/// One ping: rows of x, y, z in the world (non-finite points are skipped), and the start of its rays in the tree's
/// frame.
struct Scan {
  std::span<const float> points_world_m;
  Eigen::Vector3f origin_m;
};

/// The tree of a file, without its header.
struct TreeBytes {
  std::string body;
  std::uint64_t nodes = 0;
};

/// One bit for each voxel of a chunk, in Morton order.
using OccupiedWords = std::array<std::uint64_t, 4096>;

/// The data structure behind an OccupancyMap. Callers must validate the arguments and use an engine from only one
/// thread at a time.
class MapEngine {
 public:
  /// leaf(key, levels, log_odds): a cube with an edge of 2^levels voxels; `key` is the key of its lowest voxel.
  using LeafVisitor = std::function<void(const VoxelKey&, int, float)>;

  virtual ~MapEngine() = default;

  /// Inserts scans in order. max_range_m: negative for no limit.
  virtual void insert(std::span<const Scan> scans, double max_range_m, int threads) = 0;
  /// Fills an empty map from a file that check_octree_file() accepted; `body` is the file without its header.
  virtual void load(MapFormat format, std::string_view body) = 0;

  /// Adds log-odds to each voxel of an aligned cube with an edge of 2^levels voxels, like OctoMap's updateNodeLogOdds
  /// (log_odds.h). finish_adding() must follow the last call.
  virtual void add(const VoxelKey& corner, int levels, float log_odds) = 0;
  virtual void finish_adding() = 0;
  /// Sets the model for later scans; existing voxels keep their values.
  virtual void set_model(const OccupancyModel& model) = 0;

  /// Returns the chunks that may have changed since the last call. The first call returns all chunks and starts the
  /// recording of changes.
  virtual ChangedChunks take_changed() = 0;

  /// Returns the chunks that may contain occupied voxels; `all` if there are too many to list.
  virtual ChangedChunks occupied_chunks() const = 0;
  /// Sets the bits of a chunk's occupied voxels; all bits must be zero beforehand.
  virtual void occupied_in(std::uint32_t chunk, OccupiedWords& words) const = 0;

  virtual std::optional<float> log_odds_at(const VoxelKey& key) const = 0;
  /// Visits the leaves in Morton order. The engine determines how many equal voxels form one leaf.
  virtual void for_each_leaf(const LeafVisitor& leaf) const = 0;
  virtual VoxelCounts count() const {
    VoxelCounts voxels;
    for_each_leaf([&](const VoxelKey&, int levels, float log_odds) {
      (is_occupied(log_odds) ? voxels.occupied : voxels.free) += std::uint64_t{1} << (3 * levels);
    });
    return voxels;
  }
  /// Visits the leaves that contain voxels of the box.
  virtual void for_each_leaf_in(const KeyBox& box, const LeafVisitor& leaf) const = 0;
  /// The pruned tree of an .ot, with all log-odds; the value of an inner node is the maximum of its children.
  virtual TreeBytes full_tree() const = 0;
  /// The tree of a .bt, in which known voxels are either occupied or free, as written by OctoMap's writeBinary.
  virtual TreeBytes binary_tree() const = 0;
  /// The number of nodes in the pruned tree.
  virtual std::uint64_t nodes() const = 0;
  virtual std::size_t memory_bytes() const = 0;
};

}  // namespace uwsim
