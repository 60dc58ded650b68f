#pragma once

#include <barrier>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace uwsim {

/// A group of threads that executes the phases of a job in step: no thread starts a phase before all have finished the
/// previous one. For loops over independent items, see parallel.h.
class ThreadTeam {
 public:
  explicit ThreadTeam(std::size_t threads)
      : threads_(threads), barrier_(static_cast<std::ptrdiff_t>(threads), EndOfPhase{this}) {}

  /// Calls job(0), job(1), ... job(threads - 1), each on its own thread, with job(0) on the calling thread. If the
  /// system cannot start all threads, only the jobs of the threads that did start are called (job(0) always is). Jobs
  /// should therefore take the items of a phase from a shared counter, so that fewer threads still do all the work. An
  /// exception in a thread is rethrown here when all have finished.
  template <typename Job>
  void run(const Job& job) {
    const auto member = [&](std::size_t thread) {
      keep_error([&] { job(thread); });
      barrier_.arrive_and_drop();
    };
    {
      std::vector<std::jthread> others;
      others.reserve(threads_);
      for (std::size_t thread = 1; thread < threads_; ++thread) {
        try {
          others.emplace_back(member, thread);
        } catch (const std::exception&) {
          barrier_.arrive_and_drop();  // the system cannot start another thread, or is out of memory
        }
      }
      member(0);
    }
    if (error_) std::rethrow_exception(error_);
  }

  /// Runs one phase; every thread of the job must call it. Returns when all threads have finished the phase: true, or
  /// false on all threads if the work of any thread threw an exception. After false, the job must return.
  template <typename Work>
  bool phase(const Work& work) {
    keep_error(work);
    barrier_.arrive_and_wait();
    return !has_failed_;
  }

 private:
  struct EndOfPhase {
    ThreadTeam* team;
    void operator()() noexcept { team->has_failed_ = team->error_ != nullptr; }
  };

  template <typename Work>
  void keep_error(const Work& work) {
    try {
      work();
    } catch (...) {
      const std::scoped_lock lock(mutex_);
      if (!error_) error_ = std::current_exception();
    }
  }

  const std::size_t threads_;
  bool has_failed_ = false;  ///< written only between phases, while all threads wait
  std::barrier<EndOfPhase> barrier_;
  std::mutex mutex_;
  std::exception_ptr error_;  ///< the first exception
};

}  // namespace uwsim
