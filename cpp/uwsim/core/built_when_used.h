#pragma once

#include <atomic>
#include <mutex>
#include <optional>

#include "uwsim/core/fork_safe_mutex.h"

namespace uwsim {

/// A costly part of an immutable object, built by the first thread that uses it. If building fails, the next use tries
/// again. A forked child builds a part that its parent had not built. Thread-safe.
template <typename Part>
class BuiltWhenUsed {
 public:
  /// Returns the part, or the result of `build` if there is none yet.
  template <typename Build>
  const Part& get(const Build& build) const {
    if (!is_built_.load(std::memory_order_acquire)) [[unlikely]]
      build_once(build);
    return *part_;
  }

 private:
  template <typename Build>
  __attribute__((noinline)) void build_once(const Build& build) const {
    const std::scoped_lock lock(building_);
    if (is_built_.load(std::memory_order_relaxed)) return;
    part_.emplace(build());
    is_built_.store(true, std::memory_order_release);
  }

  mutable ForkSafeMutex<std::mutex> building_;
  mutable std::atomic<bool> is_built_ = false;
  mutable std::optional<Part> part_;
};

}  // namespace uwsim
