#pragma once

#include <cstdint>
#include <vector>

#include "uwsim/mapping/brick_store.h"

namespace uwsim::bricks {

/// Adds log-odds to cubes of voxels: unknown is 0, the sum is clamped. Nothing else may change the store meanwhile.
class BrickAdder {
 public:
  /// Throws FileError if what must leave memory cannot.
  explicit BrickAdder(BrickStore& store);
  ~BrickAdder();

  /// A cube of 2^levels voxels; `code` is the Morton code of its lowest.
  void add(std::uint64_t code, int levels, float log_odds);

 private:
  void add_large(std::uint32_t code, int levels, float log_odds);
  void add_to_all(std::uint32_t code, int levels, float log_odds);
  void split_leaf_over(std::uint32_t code, int levels);
  BrickStore::Chunk& chunk(std::uint32_t code);
  void add_to_chunk(BrickStore::Chunk& chunk, std::size_t first, std::size_t count, float log_odds);
  void add_to_brick(std::uint32_t& slot, std::size_t first, std::size_t count, float log_odds);
  float sum(float known, float log_odds) const;

  BrickStore& store_;
  BrickStore::Supply supply_;
  std::uint32_t code_ = kNone;
  BrickStore::Chunk* chunk_ = nullptr;
  std::vector<std::uint32_t> all_chunks_;  ///< codes, sorted; filled when a large cube asks for them
};

}  // namespace uwsim::bricks
