#include "uwsim/core/random.h"

#include <array>
#include <cmath>
#include <numbers>

namespace uwsim {
namespace {

using Block = std::array<std::uint32_t, 4>;

/// Uses ten rounds.
Block philox4x32(Block counter, std::uint64_t key) {
  auto k0 = static_cast<std::uint32_t>(key);
  auto k1 = static_cast<std::uint32_t>(key >> 32);
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t p0 = std::uint64_t{0xD2511F53} * counter[0];
    const std::uint64_t p1 = std::uint64_t{0xCD9E8D57} * counter[2];
    counter = {static_cast<std::uint32_t>(p1 >> 32) ^ counter[1] ^ k0, static_cast<std::uint32_t>(p1),
               static_cast<std::uint32_t>(p0 >> 32) ^ counter[3] ^ k1, static_cast<std::uint32_t>(p0)};
    k0 += 0x9E3779B9;
    k1 += 0xBB67AE85;
  }
  return counter;
}

/// Converts 52 random bits to the midpoint of one of the 2^52 equal intervals of (0, 1).
double open_unit(std::uint32_t high, std::uint32_t low) {
  const std::uint64_t bits = ((std::uint64_t{high} << 32) | low) >> 12;
  return (static_cast<double>(bits) + 0.5) * 0x1p-52;
}

Block block(std::uint64_t tick, std::uint32_t index, std::uint32_t stream, std::uint64_t key) {
  return philox4x32({static_cast<std::uint32_t>(tick), static_cast<std::uint32_t>(tick >> 32), index, stream}, key);
}

/// Two independent standard normal draws in polar coordinates (Box and Muller 1958).
struct Polar {
  double radius, angle_rad;
};

Polar polar(const Block& b) {
  return {std::sqrt(-2 * std::log(open_unit(b[0], b[1]))), 2 * std::numbers::pi * open_unit(b[2], b[3])};
}

/// FNV-1a, 32 bits.
std::uint32_t fnv1a(std::string_view text) {
  std::uint32_t hash = 2166136261u;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619u;
  return hash;
}

}  // namespace

RandomStream::RandomStream(std::uint64_t seed, std::string_view name) : key_(seed), stream_(fnv1a(name)) {}

double RandomStream::uniform(std::uint64_t tick, std::uint32_t index) const {
  const Block b = block(tick, index, stream_, key_);
  return open_unit(b[0], b[1]);
}

double RandomStream::normal(std::uint64_t tick, std::uint32_t index) const {
  const Polar drawn = polar(block(tick, index, stream_, key_));
  return drawn.radius * std::cos(drawn.angle_rad);
}

std::array<double, 2> RandomStream::normals(std::uint64_t tick, std::uint32_t index) const {
  const Polar drawn = polar(block(tick, index, stream_, key_));
  return {drawn.radius * std::cos(drawn.angle_rad), drawn.radius * std::sin(drawn.angle_rad)};
}

}  // namespace uwsim
