#include "uwsim/mapping/bricks/brick_allocator.h"

#include <algorithm>
#include <cstring>
#include <mutex>
#include <new>

namespace uwsim::bricks {
namespace {

constexpr std::size_t kBricksAtOnce = 256, kBlocksAtOnce = 1024;
constexpr std::uint64_t kAll = ~std::uint64_t{0};

}  // namespace

BrickAllocator::~BrickAllocator() {
  const std::scoped_lock lock(store_.mutex_);
  try {
    store_.spare_bricks_.insert(store_.spare_bricks_.end(), free_bricks_.begin(), free_bricks_.end());
    store_.spare_blocks_.insert(store_.spare_blocks_.end(), pool_.free, pool_.free + pool_.free_count);
  } catch (const std::bad_alloc&) {  // then these are never reused
  }
}

BlockPool& BrickAllocator::blocks(std::size_t at_least) {
  pool_.segments = reinterpret_cast<float* const*>(store_.blocks_.segments());
  free_blocks_.clear();
  free_blocks_.extend(pool_.free_count);
  if (pool_.free_count < at_least) {
    const std::scoped_lock lock(store_.mutex_);
    const std::size_t wanted = at_least + kBlocksAtOnce - pool_.free_count;
    std::uint32_t* const more = free_blocks_.reserve(wanted);
    pool_.free = free_blocks_.data();
    std::vector<std::uint32_t>& spares = store_.spare_blocks_;
    const std::size_t spare = std::min(wanted, spares.size());
    const auto fresh = static_cast<std::uint32_t>(wanted - spare);
    const std::uint32_t first = fresh == 0 ? 0 : store_.blocks_.allocate(fresh);
    std::copy(spares.end() - static_cast<std::ptrdiff_t>(spare), spares.end(), more);
    spares.resize(spares.size() - spare);
    for (std::uint32_t i = 0; i < fresh; ++i) more[spare + i] = first + fresh - 1 - i;
    free_blocks_.extend(wanted);
    pool_.free_count += static_cast<std::uint32_t>(wanted);
  }
  free_blocks_.reserve(at_least);
  pool_.free = free_blocks_.data();
  return pool_;
}

Brick& BrickAllocator::writable(std::uint32_t& slot) {
  if (slot < BrickStore::kUniform) return store_.brick(slot);
  if (free_bricks_.empty()) {
    const std::scoped_lock lock(store_.mutex_);
    const std::size_t spare = std::min(kBricksAtOnce, store_.spare_bricks_.size());
    free_bricks_.assign(store_.spare_bricks_.end() - static_cast<std::ptrdiff_t>(spare), store_.spare_bricks_.end());
    store_.spare_bricks_.resize(store_.spare_bricks_.size() - spare);
    if (spare == 0) {
      const std::uint32_t first = store_.bricks_.allocate(kBricksAtOnce);
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
    if (value <= store_.model_.clamping_min) std::fill_n(brick.at_min, 8, kAll);
    if (value != store_.model_.clamping_min) {
      BlockPool& pool = blocks(8);
      for (std::uint32_t& block : brick.block) {
        block = pool.take();
        std::fill_n(pool.at(block), 64, value);
      }
    }
  }
  slot = index;
  return brick;
}

float* BrickAllocator::writable_block(Brick& brick, int word, float known_log_odds) {
  std::uint32_t& block = brick.block[word];
  if (block != kNone) return reinterpret_cast<float*>(store_.blocks_.at(block));
  BlockPool& pool = blocks(1);
  block = pool.take();
  float* const log_odds = pool.at(block);
  for (int i = 0; i < 64; ++i) log_odds[i] = brick.known[word] >> i & 1 ? known_log_odds : 0.0f;
  return log_odds;
}

void BrickAllocator::compact(std::uint32_t& slot) {
  const Brick& brick = store_.brick(slot);
  for (int word = 0; word < 8; ++word) {
    if (brick.known[word] != kAll || brick.block[word] != kNone) return;
  }
  free_bricks_.push_back(slot);
  slot = BrickStore::kUniformAtMin;
}

}  // namespace uwsim::bricks
