#pragma once

#include <array>
#include <cstdint>

/// Keys with the bits of their axes interleaved, x lowest: the order in which an octree holds its children.
namespace uwsim::morton {

/// Bit i of `value` to bit 3 i.
constexpr std::uint64_t spread(std::uint32_t value) {
  std::uint64_t x = value & 0x1fffff;
  x = (x | x << 32) & 0x1f00000000ffff;
  x = (x | x << 16) & 0x1f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  return (x | x << 2) & 0x1249249249249249;
}

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

constexpr std::array<int, 3> key(std::uint64_t code) {
  return {static_cast<int>(gather(code)), static_cast<int>(gather(code >> 1)), static_cast<int>(gather(code >> 2))};
}

}  // namespace uwsim::morton
