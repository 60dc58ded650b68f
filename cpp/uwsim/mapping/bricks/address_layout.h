#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "uwsim/mapping/morton.h"

namespace uwsim::bricks {

/// The layout of a scan's voxels in its bitmap. An address is, from its highest bit down:
///
///   | chunk z | chunk y | chunk x |  brick in chunk  |  word in brick  |  bit in word  |
///   |   as many bits as needed    |      9 bits      |     3 bits      |    6 bits     |
///   |  for the scan's chunks      |      Morton order of the voxel in its chunk: z y x z y x ... (18 bits)
///
/// Chunks are numbered from the first one that the scan reaches. A step to the next voxel along an axis adds one to the
/// bits of that axis (axis_mask), skipping all other bits. If a scan's addresses need more than kTableBits, it does not
/// fit into the bitmap. Its addresses are then the Morton codes of the voxels' keys (48 bits), and its voxels are
/// marked in a hash table.
struct AddressLayout {
  static constexpr int kChunkBits = 18;
  /// Two tables of 512 MB of address space each; only the pages that are used take memory
  static constexpr int kTableBits = 32;

  using Key = std::array<std::uint32_t, 3>;

  /// Creates the layout for `count` rays from `origin`; ray i ends at the voxel with the key end_key[axis][i].
  AddressLayout(const Key& origin, const std::uint16_t* const* end_key, std::size_t count);

  std::uint64_t address(const Key& key) const {
    if (!fits_table) return morton::code(key[0], key[1], key[2]);
    std::uint64_t address = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      address |= static_cast<std::uint64_t>(kSpread[key[axis] & 63]) << axis;
      address |= static_cast<std::uint64_t>((key[axis] >> 6) - first_chunk[axis]) << shift[axis];
    }
    return address;
  }
  /// The address of a chunk's first voxel; x, y, z are counted in chunks from first_chunk.
  std::size_t chunk_address(std::uint32_t x, std::uint32_t y, std::uint32_t z) const {
    return std::size_t{x} << shift[0] | std::size_t{y} << shift[1] | std::size_t{z} << shift[2];
  }

  Key first_chunk{};
  Key chunks{};                ///< number of chunks along each axis
  std::array<int, 3> shift{};  ///< positions of the lowest bits of the chunk's x, y and z
  int bits = 0;                ///< number of bits of an address
  std::array<std::uint64_t, 3> axis_mask{};
  bool fits_table = false;

 private:
  /// morton::spread() of the six bits of a coordinate within a chunk.
  static constexpr std::array<std::uint32_t, 64> kSpread = [] {
    std::array<std::uint32_t, 64> table{};
    for (std::uint32_t i = 0; i < 64; ++i) table[i] = static_cast<std::uint32_t>(morton::spread(i));
    return table;
  }();
};

}  // namespace uwsim::bricks
