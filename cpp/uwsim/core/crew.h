#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>

namespace uwsim {

/// Threads that wait for work. Starting a thread for each parallel loop takes 20 us, and on a busy machine a new thread
/// begins only after the running ones have had their turns, while its creator waits for it to end.
///
/// The threads live until the process ends, and receive no signals. A forked child starts with a crew of its own.
class Crew {
 public:
  static Crew& shared();

  Crew(const Crew&) = delete;
  Crew& operator=(const Crew&) = delete;

  /// Calls job(0) on this thread, and job(1), ... job(threads - 1) on other threads, except those that have not
  /// begun by the time job(0) returns. job(0) must therefore be able to do all the work by itself. Returns when all
  /// calls have returned. `job` must not throw.
  void work(std::size_t threads, const std::function<void(std::size_t)>& job);

 private:
  struct Task {
    const std::function<void(std::size_t)>& job;
    std::size_t threads;
    std::size_t begun = 1;                // job(0) has begun ...
    std::atomic<std::size_t> running{0};  // ... and is not counted as running; changes only under the mutex
  };

  explicit Crew(int generation) : generation_(generation) {}
  void add_threads(std::size_t wanted);
  void wait_for_tasks();

  const int generation_;  // of the process to which the threads belong, see fork_generation
  std::mutex mutex_;
  std::condition_variable has_task_, has_ended_;
  std::deque<Task*> tasks_;
  std::size_t size_ = 0, idle_ = 0;
};

}  // namespace uwsim
