#include "uwsim/camera/plane.h"

#include <algorithm>
#include <mutex>

namespace uwsim {
namespace {

constexpr std::size_t kMostKept_bytes = 32 << 20;
constexpr std::size_t kLeastKept_bytes = 64 << 10;  // below, malloc keeps memory itself

struct Kept {
  std::mutex mutex;
  std::vector<std::pair<void*, std::size_t>> blocks;  // the latest last
  std::size_t bytes = 0;
};

/// Never destroyed: arrays may outlive whatever the end of a process tears down.
Kept& kept() {
  static Kept& one = *new Kept;
  return one;
}

}  // namespace

void* take_plane(std::size_t bytes) {
  if (bytes >= kLeastKept_bytes) {
    Kept& from = kept();
    const std::lock_guard alone(from.mutex);
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

void give_plane_back(void* memory, std::size_t bytes) noexcept {
  if (bytes >= kLeastKept_bytes && bytes <= kMostKept_bytes) {
    Kept& to = kept();
    try {
      const std::lock_guard alone(to.mutex);
      to.blocks.emplace_back(memory, bytes);
      to.bytes += bytes;
      while (to.bytes > kMostKept_bytes) {
        ::operator delete (to.blocks.front().first, std::align_val_t{64});
        to.bytes -= to.blocks.front().second;
        to.blocks.erase(to.blocks.begin());
      }
      return;
    } catch (const std::bad_alloc&) {  // no room for the list: let go of the block itself
    }
  }
  ::operator delete (memory, std::align_val_t{64});
}

}  // namespace uwsim
