#include <bit>

#include "uwsim/mapping/bricks/brick_octree.h"
#include "uwsim/mapping/bricks/brick_octree_walk.h"
#include "uwsim/mapping/morton.h"

namespace uwsim::bricks {
namespace {

/// A mask of the occupied voxels in a word of 64.
std::uint64_t occupied_bits(const BrickStore& store, const Brick& brick, std::size_t word) {
  if (brick.block[word] == kNone) return is_occupied(store.model().clamping_min) ? brick.known[word] : 0;
  const float* const block = store.block(brick.block[word]);
  std::uint64_t bits = 0;
  for (unsigned i = 0; i < 64; ++i) bits |= std::uint64_t{is_occupied(block[i])} << i;
  return bits & brick.known[word];
}

class LeafLister {
 public:
  explicit LeafLister(const MapEngine::LeafVisitor& visit) : visit_(visit) {}
  bool unknown() { return false; }
  bool leaf(int levels, std::uint64_t code, float log_odds) {
    visit_(morton::key(code), levels, log_odds);
    return true;
  }
  template <typename Child>
  bool inner(int, std::uint64_t, const Child& child) {
    for (unsigned i = 0; i < 8; ++i) child(i);
    return true;
  }

 private:
  const MapEngine::LeafVisitor& visit_;
};

/// Lists leaves, skipping cubes that do not intersect a box.
class BoxLister {
 public:
  BoxLister(const KeyBox& box, const MapEngine::LeafVisitor& visit) : box_(box), visit_(visit) {}
  bool unknown() { return false; }
  bool leaf(int levels, std::uint64_t code, float log_odds) {
    const VoxelKey corner = morton::key(code);
    if (box_.meets(corner, levels)) visit_(corner, levels, log_odds);
    return true;
  }
  template <typename Child>
  bool inner(int levels, std::uint64_t code, const Child& child) {
    for (unsigned i = 0; i < 8; ++i) {
      if (box_.meets(morton::key(code + (std::uint64_t{i} << (3 * (levels - 1)))), levels - 1)) child(i);
    }
    return true;
  }

 private:
  const KeyBox& box_;
  const MapEngine::LeafVisitor& visit_;
};

}  // namespace

void for_each_leaf(const BrickStore& store, const MapEngine::LeafVisitor& leaf) {
  LeafLister lister(leaf);
  OctreeWalk(store, lister).run();
}

void for_each_leaf_in(const BrickStore& store, const KeyBox& box, const MapEngine::LeafVisitor& leaf) {
  BoxLister lister(box, leaf);
  OctreeWalk(store, lister, store.sorted_chunks(box)).run();
}

std::optional<VoxelCounts> count_voxels(const BrickStore& store) {
  if (!store.large_leaves().empty()) return std::nullopt;
  VoxelCounts voxels;
  for (const auto& [code, chunk] : store.sorted_chunks()) {
    for (const std::uint32_t slot : chunk->bricks) {
      if (slot == kNone) continue;
      if (slot >= BrickStore::kUniform) {
        (is_occupied(store.uniform(slot)) ? voxels.occupied : voxels.free) += 512;
        continue;
      }
      const Brick& brick = store.brick(slot);
      for (std::size_t word = 0; word < 8; ++word) {
        const std::uint64_t occupied = occupied_bits(store, brick, word);
        voxels.occupied += static_cast<std::uint64_t>(std::popcount(occupied));
        voxels.free += static_cast<std::uint64_t>(std::popcount(brick.known[word] & ~occupied));
      }
    }
  }
  return voxels;
}

void occupied_in(const BrickStore& store, std::uint32_t code, OccupiedWords& words) {
  const BrickStore::Chunk* const chunk = store.find_chunk(code);
  if (!chunk) {
    const BrickStore::LargeLeaf* const leaf = store.large_leaf_over(code);
    if (leaf && is_occupied(leaf->log_odds)) words.fill(~std::uint64_t{0});
    return;
  }
  for (std::size_t i = 0; i < chunk->bricks.size(); ++i) {
    const std::uint32_t slot = chunk->bricks[i];
    if (slot == kNone) continue;
    for (std::size_t word = 0; word < 8; ++word) {
      if (slot < BrickStore::kUniform) {
        words[8 * i + word] = occupied_bits(store, store.brick(slot), word);
      } else if (is_occupied(store.uniform(slot))) {
        words[8 * i + word] = ~std::uint64_t{0};
      }
    }
  }
}

}  // namespace uwsim::bricks
