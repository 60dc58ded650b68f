#pragma once

#include <atomic>
#include <mutex>

namespace uwsim {

/// The number of forks between this process and the first process that used the library.
int fork_generation();

[[noreturn]] void throw_in_use_at_fork();
void pause_between_looks();

/// A mutex that does not deadlock in a forked child. The child has none of its parent's other threads, so a mutex that
/// one of them held at the fork would stay locked for ever, and the data that it guards may be only partly updated.
/// Mutex: std::mutex or std::recursive_mutex.
template <typename Mutex>
class ForkSafeMutex {
 public:
  /// Throws std::runtime_error if another thread of the parent process held the mutex at the fork.
  void lock() {
    if (!lock_unless_forked()) throw_in_use_at_fork();
  }

  /// Returns false, without locking, if another thread of the parent process held the mutex at the fork.
  bool lock_unless_forked() {
    if (try_lock()) return true;
    // A thread of this process that has just locked the mutex may not have recorded its generation yet, so look again
    for (int look = 0; generation_ != fork_generation(); ++look) {
      if (look == kLooks) return false;
      pause_between_looks();
      if (try_lock()) return true;
    }
    mutex_.lock();
    generation_ = fork_generation();
    return true;
  }

  bool try_lock() {
    if (!mutex_.try_lock()) return false;
    generation_ = fork_generation();
    return true;
  }

  void unlock() { mutex_.unlock(); }

 private:
  static constexpr int kLooks = 100;

  Mutex mutex_;
  std::atomic<int> generation_ = fork_generation();  ///< generation of the process that last locked the mutex
};

}  // namespace uwsim
