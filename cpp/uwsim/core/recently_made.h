#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "uwsim/core/fork_safe_mutex.h"

namespace uwsim {

/// Remembers costly objects that never change, so that they are made once for all who need the same. Knows those that
/// are in use, and keeps the last of those that are worth keeping for who needs it next. For several threads.
template <typename Object>
class RecentlyMade {
 public:
  /// Returns the object that `is_wanted` accepts, else what `make` returns. One thread makes at a time, so that two who
  /// need the same wait for one to be made.
  template <typename IsWanted, typename Make>
  std::shared_ptr<const Object> find_or_make(bool is_worth_keeping, const IsWanted& is_wanted, const Make& make) {
    if (!mutex_.lock_unless_forked()) return make();  // what is known here was being changed at the fork
    const std::scoped_lock lock(std::adopt_lock, mutex_);
    std::shared_ptr<const Object> object = find(is_wanted);
    if (!object) {
      if (is_worth_keeping) last_ = nullptr;  // its memory may be needed
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
