#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "uwsim/core/fork_safe_mutex.h"

namespace uwsim {

/// A cache that lets all users with the same requirements share one costly immutable object. It finds objects that are
/// still in use; in addition, it keeps the last object that is worth keeping for the next user. Thread-safe.
template <typename Object>
class RecentlyMade {
 public:
  /// Returns a cached object that `is_wanted` accepts or, if there is none, the result of `make`. Only one thread
  /// creates an object at a time, so that two threads with the same requirements share one result.
  template <typename IsWanted, typename Make>
  std::shared_ptr<const Object> find_or_make(bool is_worth_keeping, const IsWanted& is_wanted, const Make& make) {
    if (!mutex_.lock_unless_forked()) return make();  // another thread was changing the cache at the fork
    const std::scoped_lock lock(std::adopt_lock, mutex_);
    std::shared_ptr<const Object> object = find(is_wanted);
    if (!object) {
      if (is_worth_keeping) last_ = nullptr;  // release the memory before creating a new object
      in_use_.push_back(object = make());
    }
    if (is_worth_keeping) last_ = object;
    return object;
  }

 private:
  template <typename IsWanted>
  std::shared_ptr<const Object> find(const IsWanted& is_wanted) {
    std::erase_if(in_use_, [](const auto& known) { return known.expired(); });
    for (const std::weak_ptr<const Object>& known : in_use_) {
      std::shared_ptr<const Object> object = known.lock();
      if (object && is_wanted(*object)) return object;
    }
    return nullptr;
  }

  ForkSafeMutex<std::mutex> mutex_;
  std::vector<std::weak_ptr<const Object>> in_use_;
  std::shared_ptr<const Object> last_;
};

}  // namespace uwsim
