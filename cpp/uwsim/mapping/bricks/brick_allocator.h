#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "uwsim/mapping/bricks/brick_store.h"
#include "uwsim/mapping/bricks/uninitialised_vector.h"

namespace uwsim::bricks {

/// One thread's supply of free bricks and blocks from a store. They are taken from the store in batches, so that
/// threads rarely wait for each other, and are returned on destruction.
class BrickAllocator {
 public:
  explicit BrickAllocator(BrickStore& store) : store_(store) {}
  ~BrickAllocator();
  BrickAllocator(const BrickAllocator&) = delete;
  BrickAllocator& operator=(const BrickAllocator&) = delete;

  /// Returns a pool with at least `at_least` free blocks, and with room for returning the same number of blocks.
  BlockPool& blocks(std::size_t at_least);
  /// Returns the brick of a slot, for writing; creates it if the slot is kNone or uniform.
  Brick& writable(std::uint32_t& slot);
  /// Returns the block of a word, for writing. A new block contains `known_log_odds` for known voxels and 0 for unknown
  /// ones.
  float* writable_block(Brick& brick, int word, float known_log_odds);
  /// If all voxels of a slot's brick are known and at clamping_min, frees the brick and makes the slot uniform.
  void compact(std::uint32_t& slot);

 private:
  BrickStore& store_;
  BlockPool pool_{};  ///< pool_.free points into free_blocks_
  UninitialisedVector<std::uint32_t> free_blocks_;
  std::vector<std::uint32_t> free_bricks_;
};

}  // namespace uwsim::bricks
