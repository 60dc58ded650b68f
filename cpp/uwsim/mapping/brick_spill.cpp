#include "uwsim/mapping/brick_spill.h"

#include <algorithm>
#include <cstring>

#include "uwsim/core/check.h"
#include "uwsim/mapping/brick_store.h"

/// What of a BrickStore leaves memory and comes back: whole chunks, the least recently used first.
namespace uwsim::bricks {
namespace {

constexpr std::uint64_t kAll = ~std::uint64_t{0};

void put(std::vector<std::byte>& out, const void* from, std::size_t bytes) {
  const std::size_t at = out.size();
  out.resize(at + bytes);
  std::memcpy(out.data() + at, from, bytes);
}

void take(std::span<const std::byte>& in, void* to, std::size_t bytes) {
  std::memcpy(to, in.data(), bytes);
  in = in.subspan(bytes);
}

}  // namespace

void BrickStore::limit_memory(std::size_t bytes, const std::string& folder) {
  residency_ = std::make_unique<Residency>(bytes, folder);
}

std::size_t BrickStore::used_bytes() const {
  return (bricks_.taken() - spare_bricks_.size()) * sizeof(Brick) +
         (blocks_.taken() - spare_blocks_.size()) * 64 * sizeof(float) + chunks_.size() * (sizeof(Chunk) + 64);
}

/// The chunk's slots, then each of its bricks: what is known, what is at the lowest, and the blocks it has.
std::vector<std::byte> BrickStore::packed(const Chunk& chunk) const {
  std::vector<std::byte> out;
  put(out, chunk.bricks.data(), sizeof chunk.bricks);
  for (const std::uint32_t slot : chunk.bricks) {
    if (slot >= kUniform) continue;
    const Brick& from = brick(slot);
    put(out, from.known, sizeof from.known);
    put(out, from.low, sizeof from.low);
    std::uint8_t blocks = 0;
    for (int word = 0; word < 8; ++word) blocks |= static_cast<std::uint8_t>((from.block[word] != kNone) << word);
    put(out, &blocks, 1);
    for (const std::uint32_t index : from.block) {
      if (index != kNone) put(out, block(index), 64 * sizeof(float));
    }
  }
  return out;
}

void BrickStore::unpack(std::span<const std::byte> in, Chunk& chunk) {
  Supply supply(*this);
  take(in, chunk.bricks.data(), sizeof chunk.bricks);
  for (std::uint32_t& slot : chunk.bricks) {
    if (slot >= kUniform) continue;
    slot = kNone;
    Brick& to = supply.open(slot);
    take(in, to.known, sizeof to.known);
    take(in, to.low, sizeof to.low);
    std::uint8_t blocks = 0;
    take(in, &blocks, 1);
    Blocks& free = supply.blocks(8);
    for (int word = 0; word < 8; ++word) {
      if (!(blocks >> word & 1)) continue;
      to.block[word] = free.free[--free.free_count];
      take(in, free.at(to.block[word]), 64 * sizeof(float));
    }
  }
}

BrickStore::Chunk* BrickStore::restore(std::uint32_t code) {
  const auto found = residency_->saved.find(code);
  if (found == residency_->saved.end()) return nullptr;
  std::vector<std::byte> bytes(found->second.bytes);
  residency_->file.read(found->second, bytes);
  auto chunk = std::make_unique<Chunk>();
  unpack(bytes, *chunk);
  chunk->is_saved = true;
  return (chunks_[code] = std::move(chunk)).get();
}

/// Its elements go back to the reserves; the file must have it.
void BrickStore::drop(std::uint32_t code) {
  const auto found = chunks_.find(code);
  for (const std::uint32_t slot : found->second->bricks) {
    if (slot >= kUniform) continue;
    for (const std::uint32_t index : brick(slot).block) {
      if (index != kNone) spare_blocks_.push_back(index);
    }
    spare_bricks_.push_back(slot);
  }
  chunks_.erase(found);
}

void BrickStore::evict(std::uint32_t code, Chunk& chunk) {
  if (!chunk.is_saved) {
    const SpillFile::Extent extent = residency_->file.write(packed(chunk));
    const auto [at, is_new] = residency_->saved.try_emplace(code, extent);
    if (!is_new) {
      residency_->file.release(at->second);
      at->second = extent;
    }
  }
  drop(code);
  ++residency_->evictions;
}

void BrickStore::make_room() {
  if (!residency_ || used_bytes() <= residency_->limit_bytes) return;
  std::vector<std::pair<std::uint64_t, std::uint32_t>> oldest;
  oldest.reserve(chunks_.size());
  for (const auto& [code, chunk] : chunks_) oldest.emplace_back(chunk->used, code);
  std::sort(oldest.begin(), oldest.end());
  const std::size_t enough = residency_->limit_bytes - residency_->limit_bytes / 4;  // not again at once
  try {
    for (const auto& [used, code] : oldest) {
      if (used_bytes() <= enough) break;
      evict(code, *chunks_.at(code));
    }
    residency_->trouble.clear();
  } catch (const FileError& error) {
    residency_->trouble = error.what();
  }
}

void BrickStore::require_room() {
  make_room();
  if (residency_ && !residency_->trouble.empty() && used_bytes() > residency_->limit_bytes) {
    throw FileError(residency_->trouble + "; the map is whole, all of it in memory or there");
  }
}

BrickStore::Visit::Visit(const BrickStore& store, const ChunkRef& chunk)
    // A chunk that is read and dropped again leaves the store as it was.
    : store_(const_cast<BrickStore&>(store)), code_(chunk.first), chunk_(chunk.second), is_guest_(!chunk_) {
  if (is_guest_) chunk_ = store_.restore(code_);
}

BrickStore::Visit::~Visit() {
  if (is_guest_) store_.drop(code_);
}

}  // namespace uwsim::bricks
