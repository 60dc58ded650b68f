#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "uwsim/mapping/bricks/brick_allocator.h"
#include "uwsim/mapping/bricks/brick_store.h"

namespace uwsim::bricks {

/// Adds log-odds to cubes of voxels by the rule in log_odds.h, for merging maps. While it exists, the store must not be
/// changed by other means.
class CubeAdder {
 public:
  explicit CubeAdder(BrickStore& store);

  /// `code`: the Morton code of the lowest voxel of a cube of 2^levels voxels, aligned to its size.
  void add(std::uint64_t code, int levels, float log_odds);

 private:
  void add_large(std::uint32_t code, int levels, float log_odds);
  void split_large_leaf_over(std::uint32_t code, int levels);
  void add_to_large_leaves(std::uint32_t code, int levels, float log_odds);
  BrickStore::Chunk& chunk(std::uint32_t code);
  void add_to_chunk(BrickStore::Chunk& chunk, std::size_t first, std::size_t count, float log_odds);
  void add_to_brick(std::uint32_t& slot, std::size_t first, std::size_t count, float log_odds);
  float sum(float known, float log_odds) const { return clamped_sum(known, log_odds, store_.model()); }

  BrickStore& store_;
  BrickAllocator allocator_;
  std::uint32_t code_ = kNone;  ///< of chunk_, the most recently used
  BrickStore::Chunk* chunk_ = nullptr;
  std::vector<std::uint32_t> all_chunks_;  ///< sorted codes of all chunks, while a large cube is being added
};

}  // namespace uwsim::bricks
