#include "uwsim/mapping/bricks/cube_adder.h"

#include <algorithm>

#include "uwsim/mapping/morton.h"

namespace uwsim::bricks {
namespace {

constexpr std::uint32_t chunks_in(int levels) { return 1u << (3 * (levels - 6)); }

void sort_by_code(std::vector<BrickStore::LargeLeaf>& leaves) {
  std::sort(leaves.begin(), leaves.end(), [](const auto& a, const auto& b) { return a.code < b.code; });
}

}  // namespace

CubeAdder::CubeAdder(BrickStore& store) : store_(store), allocator_(store) {}

void CubeAdder::add(std::uint64_t code, int levels, float log_odds) {
  const auto chunk_code = static_cast<std::uint32_t>(code >> 18);
  if (levels > 6) return add_large(chunk_code, levels, log_odds);
  BrickStore::Chunk& into = chunk(chunk_code);
  const std::size_t brick = code >> 9 & 511;
  if (levels >= 3) return add_to_chunk(into, brick, std::size_t{1} << (3 * (levels - 3)), log_odds);
  add_to_brick(into.bricks[brick], code & 511, std::size_t{1} << (3 * levels), log_odds);
}

/// Returns a chunk for writing; creates it if necessary. The last chunk is cached, because successive cubes are often
/// in the same one.
BrickStore::Chunk& CubeAdder::chunk(std::uint32_t code) {
  if (code != code_) {
    chunk_ = &store_.writable_chunk(code);
    code_ = code;
  }
  return *chunk_;
}

void CubeAdder::add_to_chunk(BrickStore::Chunk& chunk, std::size_t first, std::size_t count, float log_odds) {
  for (std::size_t i = first; i < first + count; ++i) {
    std::uint32_t& slot = chunk.bricks[i];
    if (slot < BrickStore::kUniform) {
      add_to_brick(slot, 0, 512, log_odds);
    } else {
      slot = store_.uniform_slot(sum(slot == kNone ? 0.0f : store_.uniform(slot), log_odds));
    }
  }
}

void CubeAdder::add_to_brick(std::uint32_t& slot, std::size_t first, std::size_t count, float log_odds) {
  Brick& brick = allocator_.writable(slot);
  const float clamping_min = store_.model().clamping_min;
  for (std::size_t at = first; at < first + count; at += 64) {
    const int word = static_cast<int>(at >> 6);
    const std::uint64_t bits = morton::bits_in_word(at, std::min<std::size_t>(count, 64));
    float* const block = allocator_.writable_block(brick, word, clamping_min);
    std::uint64_t at_min = 0;
    for (std::uint64_t rest = bits; rest != 0; rest &= rest - 1) {
      float& value = block[__builtin_ctzll(rest)];
      value = sum(brick.known[word] & (rest & -rest) ? value : 0.0f, log_odds);
      if (value <= clamping_min) at_min |= rest & -rest;
    }
    brick.known[word] |= bits;
    brick.at_min[word] = (brick.at_min[word] & ~bits) | at_min;
  }
}

/// Adds to a cube that is larger than a chunk. If the whole cube is unknown, it becomes one large leaf.
void CubeAdder::add_large(std::uint32_t code, int levels, float log_odds) {
  split_large_leaf_over(code, levels);
  all_chunks_.clear();
  for (const auto& [chunk_code, unused] : store_.sorted_chunks()) all_chunks_.push_back(chunk_code);
  add_to_large_leaves(code, levels, log_odds);
  for (const std::uint32_t within : all_chunks_) {
    if (within - code < chunks_in(levels)) add_to_chunk(chunk(within), 0, 512, log_odds);
  }
}

/// Splits a leaf that is larger than the cube into eight, repeatedly, until the cube is one of them.
void CubeAdder::split_large_leaf_over(std::uint32_t code, int levels) {
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
  sort_by_code(leaves);
  store_.set_large_leaves(std::move(leaves));
}

/// Adds to the large leaves in the cube, and fills the space between leaves and chunks with new leaves, as large as
/// possible, or with new chunks.
void CubeAdder::add_to_large_leaves(std::uint32_t code, int levels, float log_odds) {
  std::vector<BrickStore::LargeLeaf> leaves = store_.large_leaves(), new_leaves;
  for (BrickStore::LargeLeaf& leaf : leaves) {
    if (leaf.code - code < chunks_in(levels)) leaf.log_odds = sum(leaf.log_odds, log_odds);
  }
  const auto leaf_in = [&](std::uint32_t first, std::uint32_t count) {
    const auto at = std::lower_bound(leaves.begin(), leaves.end(), first,
                                     [](const auto& leaf, std::uint32_t wanted) { return leaf.code < wanted; });
    return at != leaves.end() && at->code - first < count ? &*at : nullptr;
  };
  std::vector<std::uint32_t> new_chunks;
  const auto fill = [&](const auto& self, std::uint32_t first, int size) -> void {
    const std::uint32_t count = chunks_in(size);
    const auto chunk = std::lower_bound(all_chunks_.begin(), all_chunks_.end(), first);
    const bool has_chunk = chunk != all_chunks_.end() && *chunk - first < count;
    const BrickStore::LargeLeaf* leaf = size > 6 ? leaf_in(first, count) : nullptr;
    if (leaf && leaf->levels == size) return;
    if (!leaf && !has_chunk) {
      if (size > 6)
        new_leaves.push_back({first, size, sum(0, log_odds)});
      else
        new_chunks.push_back(first);
      return;
    }
    if (size == 6) return;
    for (std::uint32_t child = 0; child < 8; ++child) self(self, first + child * (count / 8), size - 1);
  };
  fill(fill, code, levels);
  leaves.insert(leaves.end(), new_leaves.begin(), new_leaves.end());
  sort_by_code(leaves);
  // No leaf covers a new chunk here, so its voxels are still unknown.
  for (const std::uint32_t made : new_chunks) add_to_chunk(chunk(made), 0, 512, log_odds);
  store_.set_large_leaves(std::move(leaves));
}

}  // namespace uwsim::bricks
