#pragma once

#include <barrier>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace uwsim {

/// Threads that go through the phases of a job together: none starts a phase before all have finished the previous one.
/// For loops over independent items see parallel.h.
class ThreadTeam {
 public:
  explicit ThreadTeam(std::size_t threads)
      : threads_(threads), barrier_(static_cast<std::ptrdiff_t>(threads), EndOfPhase{this}) {}

  /// Calls job(0), job(1), ... job(threads - 1), each on its own thread, the first on the calling one. If the system
  /// starts fewer threads, only their jobs are called, but always job(0): let the threads take the items of a phase
  /// from a shared counter, so that fewer of them still do all the work. An exception of a thread is rethrown here when
  /// all have ended.
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
          barrier_.arrive_and_drop();  // no more threads, or no memory for another
        }
      }
      member(0);
    }
    if (error_) std::rethrow_exception(error_);
  }

  /// One phase; every thread of the job calls it. Returns when all threads have done their work: true, or false on all
  /// threads if one threw, which must end the job.
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
  std::exception_ptr error_;  ///< the first one
};

}  // namespace uwsim
