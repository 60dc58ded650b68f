#pragma once

#include "uwsim/mapping/bricks/kernels/scan_kernels.h"

/// Converts entries and masks to log-odds: the update rule of log_odds.h for the voxels of bricks. Compiled into each
/// scan_kernels_*.cpp with internal linkage; only those files may include this one.
namespace uwsim::bricks {
namespace {

/// Returns the block of a word that is about to change; creates the block if the word has none. Ops::fill(block, bits,
/// value) sets voxels to `value` where `bits` is set, and to 0 elsewhere.
template <typename Ops>
inline float* block_of(Brick& brick, int word, const UpdateInput& in) {
  if (brick.block[word] == kNone) {
    brick.block[word] = in.blocks->take();
    Ops::fill(in.blocks->at(brick.block[word]), brick.known[word], in.model.clamping_min);
  }
  return in.blocks->at(brick.block[word]);
}

template <typename Ops>
inline void add_hits(Brick& brick, int word, std::uint64_t hits, const UpdateInput& in) {
  float* const block = block_of<Ops>(brick, word, in);
  for (std::uint64_t bits = hits; bits != 0; bits &= bits - 1) {
    const std::uint64_t bit = bits & -bits;
    float& value = block[__builtin_ctzll(bits)];
    if (brick.known[word] & bit) {
      if (hit_changes_nothing(value, in.model)) continue;
    }
    value = clamped_sum(value, in.model.hit, in.model);
    brick.at_min[word] = value <= in.model.clamping_min ? brick.at_min[word] | bit : brick.at_min[word] & ~bit;
  }
  brick.known[word] |= hits;
}

/// Ops::add_misses(block, todo, model) applies clamped_sum() with a miss to the voxels of `todo`, and returns a mask of
/// those that are now at or below clamping_min. Ops::all_equal(block, bits, value) returns whether all voxels of `bits`
/// have this value.
template <typename Ops>
inline void update_bricks(const UpdateInput& in) {
  const std::uint64_t* masks = in.masks;
  for (std::size_t i = 0; i < in.count; ++i) {
    const TraceEntry entry = in.entries[i];
    const std::uint64_t* const mask = masks;
    masks += __builtin_popcount(entry.missed_words) + __builtin_popcount(entry.hit_words);
    in.freed_block[i] = 0;
    if (!in.bricks[i]) continue;
    Brick& brick = *in.bricks[i];
    int at = 0;
    for (unsigned words = entry.missed_words; words != 0; words &= words - 1) {
      const int word = __builtin_ctz(words);
      const std::uint64_t missed = mask[at++];
      // A miss of 0 (a probability of 0.5) changes only unknown voxels.
      const std::uint64_t todo = missed & ~(in.model.miss < 0 ? brick.at_min[word] : brick.known[word]);
      if (todo == 0) continue;
      float* const block = block_of<Ops>(brick, word, in);
      brick.at_min[word] |= Ops::add_misses(block, todo, in.model);
      brick.known[word] |= todo;
      if (brick.at_min[word] == brick.known[word] && Ops::all_equal(block, brick.known[word], in.model.clamping_min)) {
        in.blocks->give_back(brick.block[word]);
        brick.block[word] = kNone;
        in.freed_block[i] = 1;
      }
    }
    for (unsigned words = entry.hit_words; words != 0; words &= words - 1) {
      add_hits<Ops>(brick, __builtin_ctz(words), mask[at++], in);
    }
  }
}

}  // namespace
}  // namespace uwsim::bricks
