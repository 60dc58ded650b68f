#pragma once

#include <array>
#include <cstdint>

namespace uwsim {

/// Murmur3's finalisers (Appleby, public domain): every bit of the result depends on every bit of the input.
inline std::uint64_t mixed(std::uint64_t h) {
  h = (h ^ (h >> 33)) * 0xff51afd7ed558ccdULL;
  h = (h ^ (h >> 33)) * 0xc4ceb9fe1a85ec53ULL;
  return h ^ (h >> 33);
}

inline std::uint32_t mixed(std::uint32_t h) {
  h = (h ^ (h >> 16)) * 0x85ebca6bU;
  h = (h ^ (h >> 13)) * 0xc2b2ae35U;
  return h ^ (h >> 16);
}

/// The variance of each number of byte_sums: (256^2 - 1) / 12 for a byte, and four times as much for four bytes.
inline constexpr float kByteSumVariance = 65535.0f / 3;

/// Two numbers with mean 0: sums of a hash's four bytes, with signs that make the two uncorrelated. The tests do not
/// distinguish a weighted sum of several such numbers from a normal distribution.
inline std::array<float, 2> byte_sums(std::uint32_t hash) {
  const auto a = static_cast<std::int32_t>(hash & 0xff), b = static_cast<std::int32_t>((hash >> 8) & 0xff);
  const auto c = static_cast<std::int32_t>((hash >> 16) & 0xff), d = static_cast<std::int32_t>(hash >> 24);
  const std::int32_t even = a + c, odd = b + d;
  return {static_cast<float>(even + odd - 510), static_cast<float>(even - odd)};
}

}  // namespace uwsim
