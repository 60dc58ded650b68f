#include "uwsim/mapping/bricks/chunk_spill.h"

#include <algorithm>
#include <cstring>

#include "uwsim/core/check.h"
#include "uwsim/mapping/bricks/brick_allocator.h"
#include "uwsim/mapping/bricks/brick_store.h"

/// The members of BrickStore that limit its memory: whole chunks are evicted to the spill file, least recently used
/// first, and restored when they are needed.
namespace uwsim::bricks {
namespace {

/// Additional memory of a chunk in the hash table.
constexpr std::size_t kHashBytes = 64;

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
  spill_ = std::make_unique<ChunkSpill>(bytes, folder);
}

std::uint64_t BrickStore::evictions() const { return spill_ ? spill_->evictions : 0; }

std::size_t BrickStore::memory_bytes() const {
  return sizeof(*this) + chunks_.size() * (sizeof(Chunk) + kHashBytes) + bricks_.memory_bytes() +
         blocks_.memory_bytes();
}

/// The memory that counts against the limit: chunks with their bricks and blocks, without unused reserves.
std::size_t BrickStore::used_bytes() const {
  return (bricks_.allocated() - spare_bricks_.size()) * sizeof(Brick) +
         (blocks_.allocated() - spare_blocks_.size()) * 64 * sizeof(float) +
         chunks_.size() * (sizeof(Chunk) + kHashBytes);
}

/// Returns the chunk as bytes: its slots, and then for each of its bricks `known`, `at_min`, one byte that marks which
/// words have blocks, and those blocks.
std::vector<std::byte> BrickStore::packed(const Chunk& chunk) const {
  std::vector<std::byte> out;
  put(out, chunk.bricks.data(), sizeof chunk.bricks);
  for (const std::uint32_t slot : chunk.bricks) {
    if (slot >= kUniform) continue;
    const Brick& from = brick(slot);
    put(out, from.known, sizeof from.known);
    put(out, from.at_min, sizeof from.at_min);
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
  BrickAllocator allocator(*this);
  take(in, chunk.bricks.data(), sizeof chunk.bricks);
  for (std::uint32_t& slot : chunk.bricks) {
    if (slot >= kUniform) continue;
    slot = kNone;
    Brick& to = allocator.writable(slot);
    take(in, to.known, sizeof to.known);
    take(in, to.at_min, sizeof to.at_min);
    std::uint8_t blocks = 0;
    take(in, &blocks, 1);
    BlockPool& pool = allocator.blocks(8);
    for (int word = 0; word < 8; ++word) {
      if (!(blocks >> word & 1)) continue;
      to.block[word] = pool.take();
      take(in, pool.at(to.block[word]), 64 * sizeof(float));
    }
  }
}

/// Loads a chunk from the file; returns null if it is not in the file.
BrickStore::Chunk* BrickStore::restore(std::uint32_t code) {
  const auto found = spill_->saved.find(code);
  if (found == spill_->saved.end()) return nullptr;
  std::vector<std::byte> bytes(found->second.bytes);
  spill_->file.read(found->second, bytes);
  auto chunk = std::make_unique<Chunk>();
  unpack(bytes, *chunk);
  chunk->is_saved = true;
  return (chunks_[code] = std::move(chunk)).get();
}

/// Frees a chunk that is saved in the file.
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
    const SpillFile::Extent extent = spill_->file.write(packed(chunk));
    const auto [at, is_new] = spill_->saved.try_emplace(code, extent);
    if (!is_new) {
      spill_->file.release(at->second);
      at->second = extent;
    }
  }
  drop(code);
  ++spill_->evictions;
}

void BrickStore::evict_excess() {
  if (!spill_ || used_bytes() <= spill_->limit_bytes) return;
  std::vector<std::pair<std::uint64_t, std::uint32_t>> oldest;
  oldest.reserve(chunks_.size());
  for (const auto& [code, chunk] : chunks_) oldest.emplace_back(chunk->last_use, code);
  std::sort(oldest.begin(), oldest.end());
  // evict more than necessary, so that not every call has to evict
  const std::size_t enough = spill_->limit_bytes - spill_->limit_bytes / 4;
  try {
    for (const auto& [last_use, code] : oldest) {
      if (used_bytes() <= enough) break;
      evict(code, *chunks_.at(code));
    }
    spill_->error.clear();
  } catch (const FileError& error) {
    spill_->error = error.what();
  }
}

void BrickStore::evict_excess_or_throw() {
  evict_excess();
  if (spill_ && !spill_->error.empty() && used_bytes() > spill_->limit_bytes) {
    throw FileError(spill_->error + "; the map is whole, all of it in memory or there");
  }
}

BrickStore::LoadedChunk::LoadedChunk(const BrickStore& store, const ChunkRef& chunk)
    // const is kept in effect: loading a chunk and dropping it again leaves the store unchanged.
    : store_(const_cast<BrickStore&>(store)), code_(chunk.first), chunk_(chunk.second), is_temporary_(!chunk_) {
  if (is_temporary_) chunk_ = store_.restore(code_);
}

BrickStore::LoadedChunk::~LoadedChunk() {
  if (is_temporary_) store_.drop(code_);
}

}  // namespace uwsim::bricks
