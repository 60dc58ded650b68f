#include "uwsim/core/image_buffer.h"

#include <algorithm>
#include <mutex>
#include <new>
#include <vector>

#include "uwsim/core/fork_safe_mutex.h"

namespace uwsim {
namespace {

constexpr std::size_t kMostKept_bytes = 32 << 20;
constexpr std::size_t kLeastKept_bytes = 64 << 10;  // malloc itself caches smaller blocks

struct KeptBlocks {
  ForkSafeMutex<std::mutex> mutex;
  std::vector<std::pair<void*, std::size_t>> blocks;  // most recent last
  std::size_t bytes = 0;
};

/// Never destroyed, because arrays may be freed after static objects when the process ends.
KeptBlocks& kept() {
  static KeptBlocks& one = *new KeptBlocks;
  return one;
}

}  // namespace

void* acquire_buffer(std::size_t bytes) {
  if (bytes >= kLeastKept_bytes) {
    KeptBlocks& from = kept();
    if (!from.mutex.lock_unless_forked()) return ::operator new (bytes, std::align_val_t{64});
    const std::scoped_lock lock(std::adopt_lock, from.mutex);
    const auto found = std::find_if(from.blocks.rbegin(), from.blocks.rend(),
                                    [&](const auto& block) { return block.second == bytes; });
    if (found != from.blocks.rend()) {
      void* const memory = found->first;
      from.blocks.erase(std::next(found).base());
      from.bytes -= bytes;
      return memory;
    }
  }
  return ::operator new (bytes, std::align_val_t{64});
}

void release_buffer(void* memory, std::size_t bytes) noexcept {
  if (bytes >= kLeastKept_bytes && bytes <= kMostKept_bytes) {
    KeptBlocks& to = kept();
    try {
      const std::lock_guard lock(to.mutex);
      to.blocks.emplace_back(memory, bytes);
      to.bytes += bytes;
      while (to.bytes > kMostKept_bytes) {
        ::operator delete (to.blocks.front().first, std::align_val_t{64});
        to.bytes -= to.blocks.front().second;
        to.blocks.erase(to.blocks.begin());
      }
      return;
    } catch (const std::exception&) {
      // There is no memory for the list, or the list was locked at a fork: free the block instead of keeping it
    }
  }
  ::operator delete (memory, std::align_val_t{64});
}

}  // namespace uwsim
