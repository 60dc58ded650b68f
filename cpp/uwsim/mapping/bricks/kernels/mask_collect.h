#pragma once

#include "uwsim/mapping/bricks/kernels/scan_kernels.h"

/// Converts marked voxels of one chunk to entries and masks. Compiled into each scan_kernels_*.cpp with internal
/// linkage; only those files may include this one.
namespace uwsim::bricks {
namespace {

/// Two of the operations that collect_chunk() needs, without vector instructions.
struct ScalarWords {
  static void zero_touched(std::uint8_t* bytes) { __builtin_memset(bytes, 0, 64); }

  static std::uint8_t move_nonzero(std::uint64_t* words, std::uint64_t* out) {
    unsigned which = 0;
    for (unsigned w = 0; w < 8; ++w) {
      *out = words[w];
      out += words[w] != 0;
      which |= static_cast<unsigned>(words[w] != 0) << w;
      words[w] = 0;
    }
    return static_cast<std::uint8_t>(which);
  }
};

/// Ops::touched(bytes) returns a mask of the nonzero bytes among 64. Ops::zero_touched(bytes) zeroes 64 bytes.
/// Ops::move_nonzero(words, out) copies the nonzero words among eight to `out`, zeroes all eight, and returns a mask of
/// the words copied; it may overwrite up to eight words in `out` after the copied ones.
template <typename Ops>
inline Collected collect_chunk(const CollectInput& in) {
  Collected n{0, 0};
  for (std::size_t first = 0; first < 512; first += 64) {
    for (std::uint64_t bits = Ops::touched(in.touched + first); bits != 0; bits &= bits - 1) {
      const std::size_t brick = first + static_cast<std::size_t>(__builtin_ctzll(bits));
      std::uint64_t* const missed = in.missed + 8 * brick;
      TraceEntry entry{static_cast<std::uint16_t>(brick), 0, 0};
      std::uint64_t* const hit = in.hit + 8 * brick;
      const bool has_hits = in.touched[brick] & 2;
      if (has_hits) {
        for (int w = 0; w < 8; ++w) missed[w] &= ~hit[w];  // a hit takes precedence over a miss
      }
      entry.missed_words = Ops::move_nonzero(missed, in.masks + n.masks);
      n.masks += static_cast<std::size_t>(__builtin_popcount(entry.missed_words));
      if (has_hits) {
        entry.hit_words = Ops::move_nonzero(hit, in.masks + n.masks);
        n.masks += static_cast<std::size_t>(__builtin_popcount(entry.hit_words));
      }
      in.entries[n.entries++] = entry;
    }
    Ops::zero_touched(in.touched + first);
  }
  return n;
}

}  // namespace
}  // namespace uwsim::bricks
