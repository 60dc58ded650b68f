#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "uwsim/mapping/bricks/brick_store.h"
#include "uwsim/mapping/morton.h"

namespace uwsim::bricks {

/// Walks a store as an octree, from the root to the leaves, in Morton order. The visitor has three functions, which
/// return the same type:
///   visitor.leaf(levels, code, log_odds)   a cube of 2^levels voxels that are known and equal
///   visitor.unknown()                      a cube without known voxels
///   visitor.inner(levels, code, child)     any other cube; child(i) walks its i-th eighth. Children must be visited in
///                                          order, and some may be skipped
/// `code` is the Morton code of a cube's lowest voxel.
template <typename Visitor>
class OctreeWalk {
 public:
  using Result = decltype(std::declval<Visitor&>().unknown());

  OctreeWalk(const BrickStore& store, Visitor& visitor) : OctreeWalk(store, visitor, store.sorted_chunks()) {}
  /// Walks only the given chunks, which must be in Morton order.
  OctreeWalk(const BrickStore& store, Visitor& visitor, std::vector<BrickStore::ChunkRef> chunks)
      : store_(store), visitor_(visitor), chunks_(std::move(chunks)) {}

  Result run() { return walk_chunks(kTreeDepth, 0, std::span(chunks_), std::span(store_.large_leaves()), nullptr); }

 private:
  /// Returns true only if all voxels of a cube are equal; may return false even so. levels: 1 or 2.
  bool are_equal(const Brick& brick, int first, int levels) const {
    const std::uint32_t block = brick.block[first >> 6];
    if (block == kNone) return true;  // all at clamping_min
    if (levels == 2) return false;    // the walk detects it from its eighths
    const float* const log_odds = store_.block(block) + (first & 63);
    bool equal = true;
    for (int i = 1; i < 8; ++i) equal &= log_odds[i] == log_odds[0];
    return equal;
  }

  using Chunks = std::span<const BrickStore::ChunkRef>;
  using Leaves = std::span<const BrickStore::LargeLeaf>;

  /// Walks a cube of one or more chunks. `chunks` and `leaves` are those inside the cube; `cover` is the large leaf
  /// that contains the cube, or null.
  Result walk_chunks(int levels, std::uint32_t code, Chunks chunks, Leaves leaves, const BrickStore::LargeLeaf* cover) {
    if (leaves.size() == 1 && leaves[0].levels == levels) {
      cover = &leaves[0];
      leaves = {};
    }
    if (chunks.empty() && leaves.empty()) {
      return cover ? visitor_.leaf(levels, std::uint64_t{code} << 18, cover->log_odds) : visitor_.unknown();
    }
    if (levels == 6) return walk_bricks(6, std::uint64_t{code} << 18, *chunks[0].second, 0);
    return visitor_.inner(levels, std::uint64_t{code} << 18, [&](unsigned child) {
      const std::uint32_t first = code + (child << (3 * (levels - 7)));
      const std::uint64_t end = std::uint64_t{first} + (std::uint64_t{1} << (3 * (levels - 7)));
      // The visitor may have skipped earlier children.
      while (!chunks.empty() && chunks[0].first < first) chunks = chunks.subspan(1);
      while (!leaves.empty() && leaves[0].code < first) leaves = leaves.subspan(1);
      std::size_t chunks_inside = 0, leaves_inside = 0;
      while (chunks_inside < chunks.size() && chunks[chunks_inside].first < end) ++chunks_inside;
      while (leaves_inside < leaves.size() && leaves[leaves_inside].code < end) ++leaves_inside;
      const Chunks child_chunks = chunks.first(chunks_inside);
      const Leaves child_leaves = leaves.first(leaves_inside);
      chunks = chunks.subspan(chunks_inside);
      leaves = leaves.subspan(leaves_inside);
      return walk_chunks(levels - 1, first, child_chunks, child_leaves, cover);
    });
  }

  /// Walks a cube of one or more bricks. `first`: the cube's first slot.
  Result walk_bricks(int levels, std::uint64_t code, const BrickStore::Chunk& chunk, std::size_t first) {
    if (levels == 3) {
      const std::uint32_t slot = chunk.bricks[first];
      if (slot == kNone) return visitor_.unknown();
      if (slot >= BrickStore::kUniform) return visitor_.leaf(3, code, store_.uniform(slot));
      return walk_voxels(3, code, store_.brick(slot), 0);
    }
    return visitor_.inner(levels, code, [&](unsigned child) {
      const std::size_t step = std::size_t{1} << (3 * (levels - 4));
      return walk_bricks(levels - 1, code + (std::uint64_t{child} << (3 * (levels - 1))), chunk, first + child * step);
    });
  }

  /// Walks a cube of one or more voxels. `first`: the cube's first voxel.
  Result walk_voxels(int levels, std::uint64_t code, const Brick& brick, int first) {
    if (levels == 0) {
      if (!(brick.known[first >> 6] >> (first & 63) & 1)) return visitor_.unknown();
      return visitor_.leaf(0, code, log_odds_of(store_, brick, first));
    }
    if (levels <= 2) {
      const auto voxels = morton::bits_in_word(static_cast<std::uint64_t>(first), std::size_t{1} << (3 * levels));
      const std::uint64_t known = brick.known[first >> 6] & voxels;
      if (known == 0) return visitor_.unknown();
      if (known == voxels && are_equal(brick, first, levels)) {
        return visitor_.leaf(levels, code, log_odds_of(store_, brick, first));
      }
    }
    return visitor_.inner(levels, code, [&](unsigned child) {
      const int step = 1 << (3 * (levels - 1));
      return walk_voxels(levels - 1, code + (std::uint64_t{child} << (3 * (levels - 1))), brick,
                         first + static_cast<int>(child) * step);
    });
  }

  const BrickStore& store_;
  Visitor& visitor_;
  const std::vector<BrickStore::ChunkRef> chunks_;
};

}  // namespace uwsim::bricks
