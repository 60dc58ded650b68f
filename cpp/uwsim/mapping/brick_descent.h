#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "uwsim/mapping/brick_store.h"

namespace uwsim::bricks {

/// Goes down from the octree's root to its leaves in Morton order.
///   visitor.leaf(levels, code, log_odds)   a voxel, or a cube that is the same all over
///   visitor.unknown()                      nothing there
///   visitor.inner(levels, code, child)     child(i) goes down into the i-th eighth; in order, some may be left out
/// all of which return the same type. `code` is the Morton code of a cube's lowest voxel.
template <typename Visitor>
class Descent {
 public:
  using Result = decltype(std::declval<Visitor&>().unknown());

  Descent(const BrickStore& store, Visitor& visitor) : Descent(store, visitor, store.sorted_chunks()) {}
  /// With these chunks alone, in Morton order.
  Descent(const BrickStore& store, Visitor& visitor, std::vector<BrickStore::ChunkRef> chunks)
      : store_(store), visitor_(visitor), chunks_(std::move(chunks)) {}

  Result run() { return space(kTreeLevels, 0, std::span(chunks_), std::span(store_.large_leaves()), nullptr); }

 private:
  static constexpr int kTreeLevels = 16;
  using Chunks = std::span<const BrickStore::ChunkRef>;
  using Leaves = std::span<const BrickStore::LargeLeaf>;

  /// A cube of 2^levels voxels, of a chunk or more. `cover`: the large leaf that it lies in.
  Result space(int levels, std::uint32_t code, Chunks chunks, Leaves leaves, const BrickStore::LargeLeaf* cover) {
    if (leaves.size() == 1 && leaves[0].levels == levels) {
      cover = &leaves[0];
      leaves = {};
    }
    if (chunks.empty() && leaves.empty()) {
      return cover ? visitor_.leaf(levels, std::uint64_t{code} << 18, cover->log_odds) : visitor_.unknown();
    }
    if (levels == 6) {
      const BrickStore::Visit visit(store_, chunks[0]);
      return slots(6, std::uint64_t{code} << 18, visit.chunk(), 0);
    }
    return visitor_.inner(levels, std::uint64_t{code} << 18, [&](unsigned child) {
      const std::uint32_t first = code + (child << (3 * (levels - 7)));
      const std::uint64_t end = std::uint64_t{first} + (std::uint64_t{1} << (3 * (levels - 7)));
      while (!chunks.empty() && chunks[0].first < first) chunks = chunks.subspan(1);  // of children passed over
      while (!leaves.empty() && leaves[0].code < first) leaves = leaves.subspan(1);
      std::size_t chunks_before = 0, leaves_before = 0;
      while (chunks_before < chunks.size() && chunks[chunks_before].first < end) ++chunks_before;
      while (leaves_before < leaves.size() && leaves[leaves_before].code < end) ++leaves_before;
      const Chunks inside = chunks.first(chunks_before);
      const Leaves leaves_inside = leaves.first(leaves_before);
      chunks = chunks.subspan(chunks_before);
      leaves = leaves.subspan(leaves_before);
      return space(levels - 1, first, inside, leaves_inside, cover);
    });
  }

  /// Bricks of a chunk.
  Result slots(int levels, std::uint64_t code, const BrickStore::Chunk& chunk, std::size_t first) {
    if (levels == 3) {
      const std::uint32_t slot = chunk.bricks[first];
      if (slot == kNone) return visitor_.unknown();
      if (slot >= BrickStore::kUniform) return visitor_.leaf(3, code, store_.uniform(slot));
      return voxels(3, code, store_.brick(slot), 0);
    }
    return visitor_.inner(levels, code, [&](unsigned child) {
      const std::size_t step = std::size_t{1} << (3 * (levels - 4));
      return slots(levels - 1, code + (std::uint64_t{child} << (3 * (levels - 1))), chunk, first + child * step);
    });
  }

  /// Voxels of a brick.
  Result voxels(int levels, std::uint64_t code, const Brick& brick, int first) {
    if (levels == 0) {
      if (!(brick.known[first >> 6] >> (first & 63) & 1)) return visitor_.unknown();
      return visitor_.leaf(0, code, log_odds_of(store_, brick, first));
    }
    if (levels == 2 && brick.known[first >> 6] == 0) return visitor_.unknown();
    return visitor_.inner(levels, code, [&](unsigned child) {
      const int step = 1 << (3 * (levels - 1));
      return voxels(levels - 1, code + (std::uint64_t{child} << (3 * (levels - 1))), brick,
                    first + static_cast<int>(child) * step);
    });
  }

  const BrickStore& store_;
  Visitor& visitor_;
  const std::vector<BrickStore::ChunkRef> chunks_;
};

}  // namespace uwsim::bricks
