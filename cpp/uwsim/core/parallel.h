#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace uwsim {

/// Calls job(0), job(1), ... job(threads - 1), each on a thread of its own, the first on this one. What one of them
/// throws is thrown here, when all have ended.
template <typename Job>
void on_threads(std::size_t threads, const Job& job) {
  std::mutex mutex;
  std::exception_ptr error;
  const auto run = [&](std::size_t part) {
    try {
      job(part);
    } catch (...) {
      const std::scoped_lock lock(mutex);
      if (!error) error = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> others;
    others.reserve(threads - 1);
    for (std::size_t part = 1; part < threads; ++part) {
      try {
        others.emplace_back(run, part);
      } catch (const std::system_error&) {
        run(part);  // the system gives no more threads
      }
    }
    run(0);
  }
  if (error) std::rethrow_exception(error);
}

/// Calls work(first, last) on contiguous ranges that cover [0, count), on up to `threads` threads. Results must not
/// depend on where the ranges are cut: use it for independent items only. `worth_a_thread`: how many items are enough
/// work for one.
template <typename Work>
void parallel_ranges(std::size_t count, int threads, Work&& work, std::size_t worth_a_thread = 4096) {
  const std::size_t parts = std::clamp<std::size_t>(count / worth_a_thread, 1, std::max(threads, 1));
  on_threads(parts, [&](std::size_t part) { work(part * count / parts, (part + 1) * count / parts); });
}

/// The same for items of uneven cost: each thread takes the next `share` of them when it is done with its last.
template <typename Work>
void parallel_shares(std::size_t count, std::size_t share, int threads, Work&& work) {
  const std::size_t shares = (count + share - 1) / share;
  std::atomic<std::size_t> next{0};
  on_threads(std::clamp<std::size_t>(shares, 1, std::max(threads, 1)), [&](std::size_t) {
    for (std::size_t k = next++; k < shares; k = next++) work(k * share, std::min(count, (k + 1) * share));
  });
}

}  // namespace uwsim
