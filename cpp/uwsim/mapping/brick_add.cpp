#include "uwsim/mapping/brick_add.h"

#include <algorithm>

namespace uwsim::bricks {
namespace {

constexpr std::uint32_t chunks_in(int levels) { return 1u << (3 * (levels - 6)); }

std::uint64_t bits_of(std::size_t first, std::size_t count) {
  return (count == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << count) - 1) << (first & 63);
}

}  // namespace

BrickAdder::BrickAdder(BrickStore& store) : store_(store), supply_(store) { store.require_room(); }
BrickAdder::~BrickAdder() = default;

float BrickAdder::sum(float known, float log_odds) const {
  return std::clamp(known + log_odds, store_.model().lowest, store_.model().highest);
}

void BrickAdder::add(std::uint64_t code, int levels, float log_odds) {
  const auto chunk_code = static_cast<std::uint32_t>(code >> 18);
  if (levels > 6) return add_large(chunk_code, levels, log_odds);
  BrickStore::Chunk& into = chunk(chunk_code);
  const std::size_t brick = code >> 9 & 511;
  if (levels >= 3) return add_to_chunk(into, brick, std::size_t{1} << (3 * (levels - 3)), log_odds);
  add_to_brick(into.bricks[brick], code & 511, std::size_t{1} << (3 * levels), log_odds);
}

/// Made before it is filled, so that a cube next to the last one finds it at once.
BrickStore::Chunk& BrickAdder::chunk(std::uint32_t code) {
  if (code != code_) {
    store_.make_room();
    chunk_ = &store_.chunk(code);
    code_ = code;
  }
  return *chunk_;
}

void BrickAdder::add_to_chunk(BrickStore::Chunk& chunk, std::size_t first, std::size_t count, float log_odds) {
  for (std::size_t i = first; i < first + count; ++i) {
    std::uint32_t& slot = chunk.bricks[i];
    if (slot < BrickStore::kUniform) {
      add_to_brick(slot, 0, 512, log_odds);
    } else {
      slot = store_.uniform_slot(sum(slot == kNone ? 0.0f : store_.uniform(slot), log_odds));
    }
  }
}

void BrickAdder::add_to_brick(std::uint32_t& slot, std::size_t first, std::size_t count, float log_odds) {
  Brick& brick = supply_.open(slot);
  const float lowest = store_.model().lowest;
  for (std::size_t at = first; at < first + count; at += 64) {
    const std::size_t word = at >> 6, in_word = std::min<std::size_t>(count, 64);
    const std::uint64_t bits = bits_of(at, in_word);
    Blocks& free = supply_.blocks(1);
    if (brick.block[word] == kNone) {
      brick.block[word] = free.free[--free.free_count];
      float* const block = free.at(brick.block[word]);
      for (int i = 0; i < 64; ++i) block[i] = brick.known[word] >> i & 1 ? lowest : 0.0f;
    }
    float* const block = free.at(brick.block[word]);
    std::uint64_t low = 0;
    for (std::uint64_t rest = bits; rest != 0; rest &= rest - 1) {
      float& value = block[__builtin_ctzll(rest)];
      value = sum(brick.known[word] & (rest & -rest) ? value : 0.0f, log_odds);
      if (value <= lowest) low |= rest & -rest;
    }
    brick.known[word] |= bits;
    brick.low[word] = (brick.low[word] & ~bits) | low;
  }
}

/// A cube larger than a chunk stays one leaf where the map knows nothing.
void BrickAdder::add_large(std::uint32_t code, int levels, float log_odds) {
  split_leaf_over(code, levels);
  all_chunks_.clear();
  for (const auto& [chunk_code, unused] : store_.sorted_chunks()) all_chunks_.push_back(chunk_code);
  add_to_all(code, levels, log_odds);
  for (const std::uint32_t within : all_chunks_) {
    if (within - code < chunks_in(levels)) add_to_chunk(chunk(within), 0, 512, log_odds);
  }
}

/// A leaf that is larger than the cube becomes eight, and so on, until the cube is one of them.
void BrickAdder::split_leaf_over(std::uint32_t code, int levels) {
  const BrickStore::LargeLeaf* over = store_.large_leaf_over(code);
  if (!over || over->levels <= levels) return;
  const BrickStore::LargeLeaf split = *over;
  std::vector<BrickStore::LargeLeaf> leaves;
  for (const BrickStore::LargeLeaf& leaf : store_.large_leaves()) {
    if (leaf.code != split.code) leaves.push_back(leaf);
  }
  std::uint32_t parent = split.code;
  for (int at = split.levels - 1; at >= levels; --at) {
    const std::uint32_t size = chunks_in(at), inside = parent + (code - parent) / size * size;
    for (std::uint32_t child = 0; child < 8; ++child) {
      const std::uint32_t leaf = parent + child * size;
      if (leaf != inside || at == levels) leaves.push_back({leaf, at, split.log_odds});
    }
    parent = inside;
  }
  std::sort(leaves.begin(), leaves.end(), [](const auto& a, const auto& b) { return a.code < b.code; });
  store_.set_large_leaves(std::move(leaves));
}

/// Leaves in the cube take the sum; between leaves and chunks, new ones of the largest size.
void BrickAdder::add_to_all(std::uint32_t code, int levels, float log_odds) {
  std::vector<BrickStore::LargeLeaf> leaves = store_.large_leaves(), fresh;
  for (BrickStore::LargeLeaf& leaf : leaves) {
    if (leaf.code - code < chunks_in(levels)) leaf.log_odds = sum(leaf.log_odds, log_odds);
  }
  const auto any_leaf = [&](std::uint32_t first, std::uint32_t count) {
    const auto at = std::lower_bound(leaves.begin(), leaves.end(), first,
                                     [](const auto& leaf, std::uint32_t wanted) { return leaf.code < wanted; });
    return at != leaves.end() && at->code - first < count ? &*at : nullptr;
  };
  std::vector<std::uint32_t> to_make;
  const auto go_down = [&](const auto& self, std::uint32_t first, int size) -> void {
    const std::uint32_t count = chunks_in(size);
    const auto chunk = std::lower_bound(all_chunks_.begin(), all_chunks_.end(), first);
    const bool has_chunk = chunk != all_chunks_.end() && *chunk - first < count;
    const BrickStore::LargeLeaf* leaf = size > 6 ? any_leaf(first, count) : nullptr;
    if (leaf && leaf->levels == size) return;
    if (!leaf && !has_chunk) {
      if (size > 6)
        fresh.push_back({first, size, sum(0, log_odds)});
      else
        to_make.push_back(first);
      return;
    }
    if (size == 6) return;
    for (std::uint32_t child = 0; child < 8; ++child) self(self, first + child * (count / 8), size - 1);
  };
  go_down(go_down, code, levels);
  leaves.insert(leaves.end(), fresh.begin(), fresh.end());
  std::sort(leaves.begin(), leaves.end(), [](const auto& a, const auto& b) { return a.code < b.code; });
  // A new chunk begins as what the leaf over it is: here there is none.
  for (const std::uint32_t made : to_make) add_to_chunk(chunk(made), 0, 512, log_odds);
  store_.set_large_leaves(std::move(leaves));
}

}  // namespace uwsim::bricks
