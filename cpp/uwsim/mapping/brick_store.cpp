#include "uwsim/mapping/brick_store.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <new>
#include <utility>

#include "uwsim/mapping/brick_spill.h"
#include "uwsim/mapping/morton.h"

namespace uwsim::bricks {
namespace {

constexpr std::uint32_t kIndices = 1u << 31;
constexpr std::size_t kBricksAtOnce = 256, kBlocksAtOnce = 1024;
constexpr std::size_t kSmallBytes = 256 << 10;
constexpr int kBrickSegmentBits = 15;
static_assert((sizeof(Brick) << kBrickSegmentBits) % kLargePage == 0);
constexpr std::uint64_t kAll = ~std::uint64_t{0};

/// What arenas that are gone leave for the next ones, up to so much of address space: memory that is present already.
constexpr std::size_t kKeptBytes = 64 << 20;
struct KeptSegments {
  KeptSegments() { segments.reserve(kKeptBytes / kLargePage); }

  std::mutex mutex;
  std::vector<Pages> segments;
  std::size_t bytes = 0;
};

/// Never destroyed: maps may outlive what is.
KeptSegments& kept_segments() {
  static KeptSegments& all = *new KeptSegments;
  return all;
}

Pages kept_segment(std::size_t bytes) {
  KeptSegments& kept = kept_segments();
  const std::scoped_lock lock(kept.mutex);
  for (Pages& segment : kept.segments) {
    if (segment.size() != bytes) continue;
    Pages found = std::move(segment);
    segment = std::move(kept.segments.back());
    kept.segments.pop_back();
    kept.bytes -= bytes;
    return found;
  }
  return {};
}

void fill(float* block, float value) { std::fill_n(block, 64, value); }

}  // namespace

Arena::Arena(std::size_t element_bytes, int segment_bits)
    : element_bytes_(element_bytes),
      segment_bits_(segment_bits),
      table_((kIndices >> segment_bits) * sizeof(std::byte*)) {}

Arena::~Arena() {
  KeptSegments& kept = kept_segments();
  const std::scoped_lock lock(kept.mutex);
  for (Pages& segment : segments_) {
    if (kept.bytes + segment.size() > kKeptBytes) continue;
    kept.bytes += segment.size();
    kept.segments.push_back(std::move(segment));
  }
}

/// A small map stays small: large pages come after the first few.
std::uint32_t Arena::take(std::uint32_t count) {
  if (taken_ > kIndices - count) throw std::bad_alloc();
  const std::size_t in_segment = std::size_t{1} << segment_bits_, end = std::size_t{taken_} + count;
  while (segments_.size() * in_segment < end) {
    Pages segment = kept_segment(in_segment * element_bytes_);
    if (segment.size() == 0) {
      segment = Pages(in_segment * element_bytes_, segments_.empty() ? kSmallBytes : 0);
      segment.ask_for_large();
    }
    table_.as<std::byte*>()[segments_.size()] = segment.as<std::byte>();
    segments_.push_back(std::move(segment));
  }
  for (std::size_t at = taken_; at < end;) {
    const std::size_t within = at & (in_segment - 1), some = std::min(end - at, in_segment - within);
    segments_[at >> segment_bits_].prefault(within * element_bytes_, some * element_bytes_);
    at += some;
  }
  const std::uint32_t first = taken_;
  taken_ += count;
  return first;
}

std::size_t Arena::memory_bytes() const {
  const std::size_t bytes = taken_ * element_bytes_;
  return bytes <= kSmallBytes ? bytes : (bytes + kLargePage - 1) / kLargePage * kLargePage;
}

BrickStore::BrickStore(const SensorModel& model)
    : model_(model), bricks_(sizeof(Brick), kBrickSegmentBits), blocks_(64 * sizeof(float), kSegmentBits) {
  uniform_slot(model.lowest);  // the first value: see Supply::close
}

BrickStore::~BrickStore() = default;

const BrickStore::Chunk* BrickStore::find(std::uint32_t code) const {
  const auto found = chunks_.find(code);
  if (found != chunks_.end()) return found->second.get();
  if (!residency_ || !residency_->saved.contains(code)) return nullptr;
  BrickStore& self = const_cast<BrickStore&>(*this);  // where a chunk is kept is nothing that a caller sees
  self.make_room();
  Chunk* const chunk = self.restore(code);
  chunk->used = ++residency_->now;
  return chunk;
}

const BrickStore::LargeLeaf* BrickStore::large_leaf_over(std::uint32_t code) const {
  auto after = std::upper_bound(large_leaves_.begin(), large_leaves_.end(), code,
                                [](std::uint32_t wanted, const LargeLeaf& leaf) { return wanted < leaf.code; });
  if (after == large_leaves_.begin()) return nullptr;
  const LargeLeaf& leaf = *--after;
  return (code - leaf.code) >> (3 * (leaf.levels - 6)) == 0 ? &leaf : nullptr;
}

ChangedChunks BrickStore::take_changed() { return std::exchange(changed_, {}); }

BrickStore::Chunk& BrickStore::chunk(std::uint32_t code) {
  if (!changed_.all) changed_.codes.insert(code);
  const auto found = chunks_.find(code);
  Chunk* chunk = found == chunks_.end() ? nullptr : found->second.get();
  if (!chunk && residency_) chunk = restore(code);
  if (!chunk) {
    auto made = std::make_unique<Chunk>();
    const LargeLeaf* leaf = large_leaf_over(code);
    made->bricks.fill(leaf ? uniform_slot(leaf->log_odds) : kNone);
    chunk = (chunks_[code] = std::move(made)).get();
  }
  if (residency_) {
    chunk->used = ++residency_->now;
    chunk->is_saved = false;
  }
  return *chunk;
}

std::vector<BrickStore::ChunkRef> BrickStore::sorted_chunks() const {
  std::vector<ChunkRef> sorted;
  sorted.reserve(chunks_.size());
  for (const auto& [code, chunk] : chunks_) sorted.emplace_back(code, chunk.get());
  if (residency_) {
    for (const auto& [code, extent] : residency_->saved) {
      if (!chunks_.contains(code)) sorted.emplace_back(code, nullptr);
    }
  }
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
        if (chunk != chunks_.end()) {
          found.emplace_back(code, chunk->second.get());
        } else if (residency_ && residency_->saved.contains(code)) {
          found.emplace_back(code, nullptr);
        }
      }
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

std::uint64_t BrickStore::evictions() const { return residency_ ? residency_->evictions : 0; }

void BrickStore::set_model(const SensorModel& model) {
  const float old_lowest = model_.lowest;
  model_ = model;
  if (model.lowest == old_lowest) return;
  // The first value is the lowest's: what was it before gets a value of its own.
  uniform_indices_.erase(old_lowest);
  const std::uint32_t old_slot = uniform_slot(old_lowest);
  const auto known_value = uniform_indices_.find(model.lowest);
  const std::uint32_t known_slot = known_value == uniform_indices_.end() ? kNone : kUniform | known_value->second;
  uniform_values_[0] = model.lowest;
  uniform_indices_[model.lowest] = 0;
  for (const ChunkRef& ref : sorted_chunks()) {
    make_room();
    relower(chunk(ref.first), old_slot, known_slot, old_lowest);
  }
}

/// Slots and bricks as a new lowest log-odds wants them.
void BrickStore::relower(Chunk& chunk, std::uint32_t old_slot, std::uint32_t known_slot, float old_lowest) {
  Supply supply(*this);
  for (std::uint32_t& slot : chunk.bricks) {
    if (slot == kNone) continue;
    if (slot >= kUniform) {
      if (slot == kUniform)
        slot = old_slot;
      else if (slot == known_slot)
        slot = kUniform;
      continue;
    }
    Brick& brick = this->brick(slot);
    for (int word = 0; word < 8; ++word) {
      std::uint32_t& block = brick.block[word];
      if (brick.known[word] != 0 && block == kNone) {
        Blocks& free = supply.blocks(1);
        block = free.free[--free.free_count];
        for (int i = 0; i < 64; ++i) free.at(block)[i] = brick.known[word] >> i & 1 ? old_lowest : 0.0f;
      }
      brick.low[word] = 0;
      for (std::uint64_t bits = brick.known[word]; bits != 0; bits &= bits - 1) {
        if (this->block(block)[__builtin_ctzll(bits)] <= model_.lowest) brick.low[word] |= bits & -bits;
      }
    }
  }
}

std::uint32_t BrickStore::uniform_slot(float log_odds) {
  const auto [at, is_new] = uniform_indices_.try_emplace(log_odds, static_cast<std::uint32_t>(uniform_values_.size()));
  if (is_new) uniform_values_.push_back(log_odds);
  return kUniform | at->second;
}

std::size_t BrickStore::memory_bytes() const {
  return sizeof(*this) + chunks_.size() * (sizeof(Chunk) + 64) + bricks_.memory_bytes() + blocks_.memory_bytes();
}

BrickStore::Supply::~Supply() {
  const std::scoped_lock lock(store_.mutex_);
  try {
    store_.spare_bricks_.insert(store_.spare_bricks_.end(), free_bricks_.begin(), free_bricks_.end());
    store_.spare_blocks_.insert(store_.spare_blocks_.end(), free_.free, free_.free + free_.free_count);
  } catch (const std::bad_alloc&) {  // they lie idle
  }
}

Blocks& BrickStore::Supply::blocks(std::size_t at_least) {
  free_.segments = reinterpret_cast<float* const*>(store_.blocks_.pointers());
  free_blocks_.clear();
  free_blocks_.grow(free_.free_count);
  if (free_.free_count < at_least) {
    const std::scoped_lock lock(store_.mutex_);
    const std::size_t wanted = at_least + kBlocksAtOnce - free_.free_count;
    std::uint32_t* const more = free_blocks_.room(wanted);
    free_.free = free_blocks_.data();
    std::vector<std::uint32_t>& spares = store_.spare_blocks_;
    const std::size_t spare = std::min(wanted, spares.size());
    const auto fresh = static_cast<std::uint32_t>(wanted - spare);
    const std::uint32_t first = fresh == 0 ? 0 : store_.blocks_.take(fresh);
    std::copy(spares.end() - static_cast<std::ptrdiff_t>(spare), spares.end(), more);
    spares.resize(spares.size() - spare);
    for (std::uint32_t i = 0; i < fresh; ++i) more[spare + i] = first + fresh - 1 - i;
    free_blocks_.grow(wanted);
    free_.free_count += static_cast<std::uint32_t>(wanted);
  }
  free_blocks_.room(at_least);  // as many may be given back
  free_.free = free_blocks_.data();
  return free_;
}

Brick& BrickStore::Supply::open(std::uint32_t& slot) {
  if (slot < kUniform) return store_.brick(slot);
  if (free_bricks_.empty()) {
    const std::scoped_lock lock(store_.mutex_);
    const std::size_t spare = std::min(kBricksAtOnce, store_.spare_bricks_.size());
    free_bricks_.assign(store_.spare_bricks_.end() - static_cast<std::ptrdiff_t>(spare), store_.spare_bricks_.end());
    store_.spare_bricks_.resize(store_.spare_bricks_.size() - spare);
    if (spare == 0) {
      const std::uint32_t first = store_.bricks_.take(kBricksAtOnce);
      for (std::uint32_t i = kBricksAtOnce; i-- > 0;) free_bricks_.push_back(first + i);
    }
  }
  const std::uint32_t index = free_bricks_.back();
  free_bricks_.pop_back();
  Brick& brick = store_.brick(index);
  std::memset(&brick, 0, sizeof brick);
  std::fill_n(brick.block, 8, kNone);
  if (slot != kNone) {
    const float value = store_.uniform(slot);
    std::fill_n(brick.known, 8, kAll);
    if (value <= store_.model_.lowest) std::fill_n(brick.low, 8, kAll);
    if (value != store_.model_.lowest) {
      Blocks& supply = blocks(8);
      for (std::uint32_t& block : brick.block) {
        block = supply.free[--supply.free_count];
        fill(supply.at(block), value);
      }
    }
  }
  slot = index;
  return brick;
}

void BrickStore::Supply::close(std::uint32_t& slot) {
  const Brick& brick = store_.brick(slot);
  for (int word = 0; word < 8; ++word) {
    if (brick.known[word] != kAll || brick.block[word] != kNone) return;
  }
  free_bricks_.push_back(slot);
  slot = kUniform;  // with the first value
}

}  // namespace uwsim::bricks
