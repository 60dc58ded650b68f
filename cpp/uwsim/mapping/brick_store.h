#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "uwsim/mapping/growing.h"
#include "uwsim/mapping/map_engine.h"
#include "uwsim/mapping/pages.h"
#include "uwsim/mapping/scan_kernels.h"

namespace uwsim::bricks {

/// Elements of a fixed size that never move, by index; what is in new ones is anything. Handing out is for one thread
/// at a time; looking up is for all.
class Arena {
 public:
  /// In segments of 2^segment_bits elements.
  Arena(std::size_t element_bytes, int segment_bits);
  ~Arena();
  Arena(const Arena&) = delete;
  Arena& operator=(const Arena&) = delete;

  /// The first of `count` new elements. Throws std::bad_alloc.
  std::uint32_t take(std::uint32_t count);
  std::byte* at(std::uint32_t index) const {
    return pointers()[index >> segment_bits_] + element_bytes_ * (index & ((1u << segment_bits_) - 1));
  }
  std::uint32_t taken() const { return taken_; }
  std::byte* const* pointers() const { return table_.as<std::byte*>(); }
  std::size_t memory_bytes() const;

 private:
  std::size_t element_bytes_;
  int segment_bits_;
  std::uint32_t taken_ = 0;
  Pages table_;  ///< of segments; in pages of its own, so that it never moves
  std::vector<Pages> segments_;
};

struct Residency;

/// The voxels of a map: bricks of 8 x 8 x 8 in chunks of 8 x 8 x 8 bricks, found by a hash. What is the same all over
/// (a brick seen free until it could be no freer, a large leaf of a file) is kept as one value.
class BrickStore {
 public:
  /// 512 bricks in Morton order: kNone, an index of a brick, or kUniform with an index of a value.
  struct Chunk {
    std::array<std::uint32_t, 512> bricks;
    std::uint64_t used = 0;  ///< when it last was
    bool is_saved = false;   ///< as it is, in the file of what leaves memory
  };
  static constexpr std::uint32_t kUniform = 0x80000000;

  /// A chunk and its code; null if it is not in memory.
  using ChunkRef = std::pair<std::uint32_t, const Chunk*>;

  /// A leaf of a file that is larger than a chunk.
  struct LargeLeaf {
    std::uint32_t code;  ///< of its first chunk
    int levels;          ///< above the finest, more than 6
    float log_odds;
  };

  explicit BrickStore(const SensorModel& model);
  ~BrickStore();

  const SensorModel& model() const { return model_; }
  /// For later scans: the voxels stay as they are.
  void set_model(const SensorModel& model);

  /// Keeps what the chunks take near so many bytes: those that were not used for longest go to a file in `folder`
  /// (empty: the system's), and come back when they are used. Throws FileError.
  void limit_memory(std::size_t bytes, const std::string& folder);
  bool is_limited() const { return residency_ != nullptr; }
  /// Sends chunks away if there are too many: what find() and chunk() gave before may be gone. If the file cannot be
  /// written they stay.
  void make_room();
  /// The same; throws FileError if the file cannot be written and there are too many.
  void require_room();
  std::uint64_t evictions() const;
  /// A chunk while it is looked at, out of the file if need be.
  class Visit {
   public:
    Visit(const BrickStore& store, const ChunkRef& chunk);
    ~Visit();
    Visit(const Visit&) = delete;
    Visit& operator=(const Visit&) = delete;
    const Chunk& chunk() const { return *chunk_; }

   private:
    BrickStore& store_;
    const std::uint32_t code_;
    const Chunk* chunk_;
    const bool is_guest_;
  };

  /// Chunks that chunk() gave since it was last asked, all at first; recorded from then on.
  ChangedChunks take_changed();
  ChangedChunks& changed() { return changed_; }

  /// What is held is good until the next call.
  const Chunk* find(std::uint32_t code) const;
  /// Makes the chunk if need be, out of the large leaf that covers it if there is one. For one thread at a time.
  Chunk& chunk(std::uint32_t code);
  /// In Morton order.
  std::vector<ChunkRef> sorted_chunks() const;
  std::vector<ChunkRef> sorted_chunks(const KeyBox& box) const;
  const std::vector<LargeLeaf>& large_leaves() const { return large_leaves_; }
  /// In Morton order of their codes, none within another; where there are chunks, they are what counts.
  void add_large_leaf(const LargeLeaf& leaf) { large_leaves_.push_back(leaf); }
  void set_large_leaves(std::vector<LargeLeaf> leaves) { large_leaves_ = std::move(leaves); }
  const LargeLeaf* large_leaf_over(std::uint32_t code) const;

  Brick& brick(std::uint32_t index) const { return *reinterpret_cast<Brick*>(bricks_.at(index)); }
  const float* block(std::uint32_t index) const { return reinterpret_cast<const float*>(blocks_.at(index)); }
  float uniform(std::uint32_t slot) const { return uniform_values_[slot & ~kUniform]; }
  /// The slot of a brick that is `log_odds` all over. For one thread at a time.
  std::uint32_t uniform_slot(float log_odds);

  /// Free bricks and blocks of one thread.
  class Supply {
   public:
    explicit Supply(BrickStore& store) : store_(store) {}
    ~Supply();
    Supply(const Supply&) = delete;
    Supply& operator=(const Supply&) = delete;

    /// At least so many free blocks.
    Blocks& blocks(std::size_t at_least);
    /// The brick behind a slot, made if there is none, spread out if it was uniform.
    Brick& open(std::uint32_t& slot);
    /// Keeps a brick that is the lowest all over as such, if it is.
    void close(std::uint32_t& slot);

   private:
    BrickStore& store_;
    Blocks free_{};
    Growing<std::uint32_t> free_blocks_;
    std::vector<std::uint32_t> free_bricks_;
  };

  /// What the map holds, its reserves included.
  std::size_t memory_bytes() const;

 private:
  friend class Visit;

  std::size_t used_bytes() const;
  std::vector<std::byte> packed(const Chunk& chunk) const;
  void unpack(std::span<const std::byte> in, Chunk& chunk);
  /// Null if the file does not have it.
  Chunk* restore(std::uint32_t code);
  void drop(std::uint32_t code);
  void evict(std::uint32_t code, Chunk& chunk);
  void relower(Chunk& chunk, std::uint32_t old_slot, std::uint32_t known_slot, float old_lowest);

  SensorModel model_;
  std::unordered_map<std::uint32_t, std::unique_ptr<Chunk>> chunks_;
  std::vector<LargeLeaf> large_leaves_;
  std::vector<float> uniform_values_;
  std::unordered_map<float, std::uint32_t> uniform_indices_;
  Arena bricks_, blocks_;
  std::vector<std::uint32_t> spare_bricks_, spare_blocks_;
  std::mutex mutex_;
  ChangedChunks changed_{true, {}};
  std::unique_ptr<Residency> residency_;  ///< null: all of it stays in memory
};

/// Log-odds of a voxel of a brick, known or not: `index` in Morton order.
inline float log_odds_of(const BrickStore& store, const Brick& brick, int index) {
  const std::uint32_t block = brick.block[index >> 6];
  return block == kNone ? store.model().lowest : store.block(block)[index & 63];
}

}  // namespace uwsim::bricks
