#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "uwsim/core/fork_safe_mutex.h"

namespace uwsim {

/// The tiles of a large area, of which each is made when it is first used. When those in memory hold more than a number
/// of items, the ones that were not used for longest are released, until half of that number is free: memory does not
/// depend on the area. What a tile holds must depend on its index alone. Thread-safe.
template <typename Tile>
class KeptTiles {
 public:
  static constexpr std::size_t kStripes = 32;

  /// Keeps the tiles in memory while it lives: each thread has a stripe, which is free except while tiles are released.
  class InUse {
   public:
    explicit InUse(const KeptTiles& tiles)
        : tiles_(tiles), lock_(tiles.stripes_[own_number() % tiles.stripes_.size()].mutex) {}
    ~InUse() {
      lock_.unlock();
      if (tiles_.items_ > tiles_.most_items_) tiles_.release_oldest();
    }
    InUse(const InUse&) = delete;
    InUse& operator=(const InUse&) = delete;

   private:
    static unsigned own_number() {
      static std::atomic<unsigned> threads = 0;
      thread_local const unsigned number = threads++;
      return number;
    }

    const KeptTiles& tiles_;
    std::unique_lock<ForkSafeMutex<std::mutex>> lock_;
  };

  KeptTiles(std::size_t count, std::size_t most_items) : most_items_(most_items), slots_(count) {}
  ~KeptTiles() {
    for (const std::atomic<const Kept*>& slot : slots_) delete slot.load();
  }
  KeptTiles(const KeptTiles&) = delete;
  KeptTiles& operator=(const KeptTiles&) = delete;

  std::size_t items() const { return items_; }
  bool is_made(std::size_t index) const { return slots_[index].load(std::memory_order_acquire) != nullptr; }

  /// The tile, or the result of `make` if it is not in memory. It stays while an InUse of this thread lives.
  template <typename Make>
  const Tile& get(std::size_t index, const Make& make) const {
    std::atomic<const Kept*>& slot = slots_[index];
    const Kept* found = slot.load(std::memory_order_acquire);
    if (found == nullptr) {
      auto made = std::make_unique<const Kept>(make);
      made->used = ++clock_;
      // If another thread was faster, its tile, which is equal, is used.
      if (slot.compare_exchange_strong(found, made.get(), std::memory_order_acq_rel)) {
        items_ += made->tile.items();
        found = made.release();
      }
    }
    const std::uint32_t now = clock_.load(std::memory_order_relaxed);
    if (found->used.load(std::memory_order_relaxed) != now) found->used.store(now, std::memory_order_relaxed);
    return found->tile;
  }

 private:
  struct Kept {
    Tile tile;
    mutable std::atomic<std::uint32_t> used = 0;  ///< when it was last used

    template <typename Make>
    explicit Kept(const Make& make) : tile(make()) {}
  };
  struct alignas(64) Stripe {
    ForkSafeMutex<std::mutex> mutex;
  };

  /// Releases tiles, unless another thread has.
  void release_oldest() const {
    std::array<std::unique_lock<ForkSafeMutex<std::mutex>>, kStripes> all;
    for (std::size_t k = 0; k < kStripes; ++k) {
      if (!stripes_[k].mutex.lock_unless_forked()) return;  // a thread of the parent process keeps it
      all[k] = {stripes_[k].mutex, std::adopt_lock};
    }
    if (items_ <= most_items_) return;
    std::vector<std::pair<std::uint32_t, std::size_t>> used;
    for (std::size_t n = 0; n < slots_.size(); ++n) {
      if (const Kept* kept = slots_[n].load()) used.emplace_back(kept->used, n);
    }
    std::ranges::sort(used);
    for (const auto& [when, n] : used) {
      if (items_ <= most_items_ / 2) return;
      const Kept* kept = slots_[n].exchange(nullptr);
      items_ -= kept->tile.items();
      delete kept;
    }
  }

  std::size_t most_items_;
  mutable std::vector<std::atomic<const Kept*>> slots_;
  mutable std::array<Stripe, kStripes> stripes_;  ///< a thread that uses tiles holds its own; releasing tiles takes all
  mutable std::atomic<std::size_t> items_ = 0;
  mutable std::atomic<std::uint32_t> clock_ = 0;
};

}  // namespace uwsim
