#include "uwsim/mapping/bricks/brick_store.h"

#include <algorithm>
#include <utility>

#include "uwsim/mapping/bricks/brick_allocator.h"
#include "uwsim/mapping/morton.h"

namespace uwsim::bricks {
namespace {

constexpr int kBrickSegmentBits = 15;
static_assert((sizeof(Brick) << kBrickSegmentBits) % kHugePage == 0);

}  // namespace

BrickStore::BrickStore(const OccupancyLogOdds& model)
    : model_(model), bricks_(sizeof(Brick), kBrickSegmentBits), blocks_(64 * sizeof(float), BlockPool::kSegmentBits) {
  uniform_slot(model.clamping_min);  // kUniformAtMin
}

std::size_t BrickStore::memory_bytes() const {
  constexpr std::size_t kHashBytes = 64;  // of a chunk's entry in the hash table
  return sizeof(*this) + chunks_.size() * (sizeof(Chunk) + kHashBytes) + bricks_.memory_bytes() +
         blocks_.memory_bytes();
}

const BrickStore::Chunk* BrickStore::find_chunk(std::uint32_t code) const {
  const auto found = chunks_.find(code);
  return found == chunks_.end() ? nullptr : found->second.get();
}

const BrickStore::LargeLeaf* BrickStore::large_leaf_over(std::uint32_t code) const {
  auto after = std::upper_bound(large_leaves_.begin(), large_leaves_.end(), code,
                                [](std::uint32_t wanted, const LargeLeaf& leaf) { return wanted < leaf.code; });
  if (after == large_leaves_.begin()) return nullptr;
  const LargeLeaf& leaf = *--after;
  return (code - leaf.code) >> (3 * (leaf.levels - 6)) == 0 ? &leaf : nullptr;
}

ChangedChunks BrickStore::take_changed() { return std::exchange(changed_, {}); }

BrickStore::Chunk& BrickStore::writable_chunk(std::uint32_t code) {
  if (!changed_.all) changed_.codes.insert(code);
  const auto found = chunks_.find(code);
  if (found != chunks_.end()) return *found->second;
  auto made = std::make_unique<Chunk>();
  const LargeLeaf* leaf = large_leaf_over(code);
  made->bricks.fill(leaf ? uniform_slot(leaf->log_odds) : kNone);
  return *(chunks_[code] = std::move(made));
}

std::vector<BrickStore::ChunkRef> BrickStore::sorted_chunks() const {
  std::vector<ChunkRef> sorted;
  sorted.reserve(chunks_.size());
  for (const auto& [code, chunk] : chunks_) sorted.emplace_back(code, chunk.get());
  std::sort(sorted.begin(), sorted.end());
  return sorted;
}

std::vector<BrickStore::ChunkRef> BrickStore::sorted_chunks(const KeyBox& box) const {
  std::array<std::uint32_t, 3> low, high;
  std::uint64_t in_box = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    low[axis] = static_cast<std::uint32_t>(box.low[axis]) >> 6;
    high[axis] = static_cast<std::uint32_t>(box.high[axis]) >> 6;
    in_box *= high[axis] - low[axis] + 1;
  }
  std::vector<ChunkRef> found;
  if (in_box > chunks_.size()) {
    for (const ChunkRef& chunk : sorted_chunks()) {
      if (box.meets(morton::key(std::uint64_t{chunk.first} << 18), 6)) found.push_back(chunk);
    }
    return found;
  }
  for (std::uint32_t z = low[2]; z <= high[2]; ++z) {
    for (std::uint32_t y = low[1]; y <= high[1]; ++y) {
      for (std::uint32_t x = low[0]; x <= high[0]; ++x) {
        const auto code = static_cast<std::uint32_t>(morton::code(x, y, z));
        const auto chunk = chunks_.find(code);
        if (chunk != chunks_.end()) found.emplace_back(code, chunk->second.get());
      }
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

void BrickStore::set_model(const OccupancyLogOdds& model) {
  const float old_min = model_.clamping_min;
  model_ = model;
  if (model.clamping_min == old_min) return;
  // The first uniform value becomes the new clamping_min; the old one gets a separate slot.
  uniform_indices_.erase(old_min);
  const std::uint32_t old_slot = uniform_slot(old_min);
  const auto known_value = uniform_indices_.find(model.clamping_min);
  const std::uint32_t known_slot = known_value == uniform_indices_.end() ? kNone : kUniform | known_value->second;
  uniform_values_[0] = model.clamping_min;
  uniform_indices_[model.clamping_min] = 0;
  for (const ChunkRef& ref : sorted_chunks()) {
    move_clamping_min(writable_chunk(ref.first), old_slot, known_slot, old_min);
  }
}

/// Adapts a chunk to a new clamping_min. old_slot: the new slot for uniform bricks whose value is the old clamping_min.
/// known_slot: the previous slot for uniform bricks whose value is the new clamping_min, or kNone.
void BrickStore::move_clamping_min(Chunk& chunk, std::uint32_t old_slot, std::uint32_t known_slot, float old_min) {
  BrickAllocator allocator(*this);
  for (std::uint32_t& slot : chunk.bricks) {
    if (slot == kNone) continue;
    if (slot >= kUniform) {
      if (slot == kUniformAtMin)
        slot = old_slot;
      else if (slot == known_slot)
        slot = kUniformAtMin;
      continue;
    }
    Brick& brick = this->brick(slot);
    for (int word = 0; word < 8; ++word) {
      if (brick.known[word] != 0) allocator.writable_block(brick, word, old_min);
      brick.at_min[word] = 0;
      for (std::uint64_t bits = brick.known[word]; bits != 0; bits &= bits - 1) {
        const float log_odds = block(brick.block[word])[__builtin_ctzll(bits)];
        if (log_odds <= model_.clamping_min) brick.at_min[word] |= bits & -bits;
      }
    }
  }
}

std::uint32_t BrickStore::uniform_slot(float log_odds) {
  const auto [at, is_new] = uniform_indices_.try_emplace(log_odds, static_cast<std::uint32_t>(uniform_values_.size()));
  if (is_new) uniform_values_.push_back(log_odds);
  return kUniform | at->second;
}

}  // namespace uwsim::bricks
