#pragma once

#include <cstddef>
#include <cstdint>

/// The smallest parts of the map's storage, as plain structs that the kernels of every instruction set can use.
namespace uwsim::bricks {

/// The index that means "no brick" or "no block".
inline constexpr std::uint32_t kNone = 0xffffffff;

/// 8 x 8 x 8 voxels in Morton order. Word w covers the 4 x 4 x 4 voxels 64 w to 64 w + 63, whose log-odds are in one
/// block. A word needs no block while all of its known voxels are exactly at clamping_min, as is the case for most of
/// the water in a survey.
struct alignas(64) Brick {
  std::uint64_t known[8];
  std::uint64_t at_min[8];  ///< known and at or below clamping_min: unaffected by misses
  std::uint32_t block[8];   ///< kNone, or the index of a block of 64 log-odds; 0 where a voxel is unknown
};

/// Blocks of 64 log-odds: their addresses, and a stack of free ones.
struct BlockPool {
  static constexpr int kSegmentBits = 13;  ///< a segment of 2^13 blocks is one huge page of 2 MB

  float* const* segments;
  std::uint32_t* free;
  std::uint32_t free_count;

  float* at(std::uint32_t block) const {
    return segments[block >> kSegmentBits] + 64 * std::size_t{block & ((1u << kSegmentBits) - 1)};
  }
  std::uint32_t take() { return free[--free_count]; }
  void give_back(std::uint32_t block) { free[free_count++] = block; }
};

}  // namespace uwsim::bricks
