#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

/// Morton codes, which interleave the bits of a key's coordinates, x lowest. An octree visited child by child lists its
/// voxels in the order of their codes. The voxels of an aligned cube with an edge of 2^n voxels have 8^n consecutive
/// codes.
namespace uwsim::morton {

/// Moves bit i of `value` to bit 3 i.
constexpr std::uint64_t spread(std::uint32_t value) {
  std::uint64_t x = value & 0x1fffff;
  x = (x | x << 32) & 0x1f00000000ffff;
  x = (x | x << 16) & 0x1f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  return (x | x << 2) & 0x1249249249249249;
}

/// Moves bit 3 i of `code` to bit i.
constexpr std::uint32_t gather(std::uint64_t code) {
  std::uint64_t x = code & 0x1249249249249249;
  x = (x | x >> 2) & 0x10c30c30c30c30c3;
  x = (x | x >> 4) & 0x100f00f00f00f00f;
  x = (x | x >> 8) & 0x1f0000ff0000ff;
  x = (x | x >> 16) & 0x1f00000000ffff;
  return static_cast<std::uint32_t>((x | x >> 32) & 0x1fffff);
}

constexpr std::uint64_t code(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  return spread(x) | spread(y) << 1 | spread(z) << 2;
}
constexpr std::uint64_t code(const std::array<int, 3>& key) {
  return code(static_cast<std::uint32_t>(key[0]), static_cast<std::uint32_t>(key[1]),
              static_cast<std::uint32_t>(key[2]));
}

constexpr std::array<int, 3> key(std::uint64_t code) {
  return {static_cast<int>(gather(code)), static_cast<int>(gather(code >> 1)), static_cast<int>(gather(code >> 2))};
}

/// A mask, in a word of 64 voxels, of the `count` voxels from code `first` on; `count` is 1, 8 or 64.
constexpr std::uint64_t bits_in_word(std::uint64_t first, std::size_t count) {
  return (count == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << count) - 1) << (first & 63);
}

}  // namespace uwsim::morton
