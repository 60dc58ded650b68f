#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <utility>
#include <vector>

#include "uwsim/mapping/bricks/arena.h"
#include "uwsim/mapping/bricks/brick.h"
#include "uwsim/mapping/changed_chunks.h"
#include "uwsim/mapping/log_odds.h"
#include "uwsim/mapping/voxel_key.h"

namespace uwsim::bricks {

/// The voxels of a map: chunks of 8 x 8 x 8 bricks of 8 x 8 x 8 voxels, found in a hash table. A brick whose voxels are
/// all known and equal is stored as a single value, and so is a leaf, read from a file, that is larger than a chunk.
/// README.md shows the levels.
class BrickStore {
 public:
  /// 512 slots in Morton order. A slot is kNone (all voxels unknown), kUniform + the index of a value (all known and
  /// equal), or the index of a brick.
  struct Chunk {
    std::array<std::uint32_t, 512> bricks;
  };
  static constexpr std::uint32_t kUniform = 0x80000000;
  static constexpr std::uint32_t kUniformAtMin = kUniform;  ///< the first value is always clamping_min

  /// A chunk's code (the Morton code of its first voxel without the lowest 18 bits) and the chunk.
  using ChunkRef = std::pair<std::uint32_t, const Chunk*>;

  /// A cube of 2^levels voxels that are all known and equal.
  struct LargeLeaf {
    std::uint32_t code;  ///< of the leaf's first chunk
    int levels;          ///< more than 6, the number of levels of a chunk
    float log_odds;
  };

  explicit BrickStore(const OccupancyLogOdds& model);

  const OccupancyLogOdds& model() const { return model_; }
  /// Sets the model for later scans; existing voxels keep their values.
  void set_model(const OccupancyLogOdds& model);

  /// The memory of the map, including unused reserves.
  std::size_t memory_bytes() const;

  // Chunks:

  /// Returns null if the map has no such chunk.
  const Chunk* find_chunk(std::uint32_t code) const;
  /// Returns a chunk for writing; if there is none, it is created and filled from the large leaf that covers it, if
  /// any. Not thread-safe.
  Chunk& writable_chunk(std::uint32_t code);
  /// All chunks, in Morton order.
  std::vector<ChunkRef> sorted_chunks() const;
  std::vector<ChunkRef> sorted_chunks(const KeyBox& box) const;
  /// Returns the chunks that may have changed since the last call. The first call returns `all` and starts the
  /// recording of changes.
  ChangedChunks take_changed();
  ChangedChunks& changed() { return changed_; }

  /// Sorted by code; leaves do not overlap. If a chunk lies inside a large leaf, the chunk takes precedence.
  const std::vector<LargeLeaf>& large_leaves() const { return large_leaves_; }
  void add_large_leaf(const LargeLeaf& leaf) { large_leaves_.push_back(leaf); }
  void set_large_leaves(std::vector<LargeLeaf> leaves) { large_leaves_ = std::move(leaves); }
  /// Returns the large leaf that contains a chunk, or null if there is none.
  const LargeLeaf* large_leaf_over(std::uint32_t code) const;

  // Bricks:

  Brick& brick(std::uint32_t index) const { return *reinterpret_cast<Brick*>(bricks_.at(index)); }
  const float* block(std::uint32_t index) const { return reinterpret_cast<const float*>(blocks_.at(index)); }
  /// The log-odds of a uniform slot.
  float uniform(std::uint32_t slot) const { return uniform_values_[slot & ~kUniform]; }
  /// The slot of a uniform brick. Not thread-safe.
  std::uint32_t uniform_slot(float log_odds);

 private:
  friend class BrickAllocator;

  void move_clamping_min(Chunk& chunk, std::uint32_t old_slot, std::uint32_t known_slot, float old_min);

  OccupancyLogOdds model_;
  std::unordered_map<std::uint32_t, std::unique_ptr<Chunk>> chunks_;
  std::vector<LargeLeaf> large_leaves_;
  std::vector<float> uniform_values_;
  std::unordered_map<float, std::uint32_t> uniform_indices_;
  Arena bricks_, blocks_;
  std::vector<std::uint32_t> spare_bricks_, spare_blocks_;  ///< allocated but not used
  std::mutex mutex_;                                        ///< guards the arenas and the spares
  ChangedChunks changed_{true, {}};
};

/// Log-odds of a known voxel of a brick; `index` in Morton order.
inline float log_odds_of(const BrickStore& store, const Brick& brick, int index) {
  const std::uint32_t block = brick.block[index >> 6];
  return block == kNone ? store.model().clamping_min : store.block(block)[index & 63];
}

}  // namespace uwsim::bricks
