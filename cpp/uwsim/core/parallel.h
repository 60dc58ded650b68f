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

/// Calls work(first, last) on contiguous ranges that cover [0, count), on up to `threads` threads. Results must not
/// depend on where the ranges are cut: use it for independent items only. `worth_a_thread`: how many items are enough
/// work for one. What one of them throws is thrown here, when all have ended.
template <typename Work>
void parallel_ranges(std::size_t count, int threads, Work&& work, std::size_t worth_a_thread = 4096) {
  const std::size_t parts = std::clamp<std::size_t>(count / worth_a_thread, 1, std::max(threads, 1));
  std::mutex mutex;
  std::exception_ptr error;
  const auto do_part = [&](std::size_t part) {
    try {
      work(part * count / parts, (part + 1) * count / parts);
    } catch (...) {
      const std::scoped_lock lock(mutex);
      if (!error) error = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> others;
    others.reserve(parts - 1);
    for (std::size_t part = 1; part < parts; ++part) {
      try {
        others.emplace_back(do_part, part);
      } catch (const std::system_error&) {
        do_part(part);  // the system gives no more threads
      }
    }
    do_part(0);
  }
  if (error) std::rethrow_exception(error);
}

/// The same for items of uneven cost: each thread takes the next `share` of them when it is done with its last.
template <typename Work>
void parallel_shares(std::size_t count, std::size_t share, int threads, Work&& work) {
  const std::size_t shares = (count + share - 1) / share;
  std::atomic<std::size_t> next{0};
  const auto take = [&] {
    for (std::size_t k = next++; k < shares; k = next++) work(k * share, std::min(count, (k + 1) * share));
  };
  const std::size_t parts = std::clamp<std::size_t>(shares, 1, std::max(threads, 1));
  std::vector<std::jthread> others;
  for (std::size_t part = 1; part < parts; ++part) others.emplace_back(take);
  take();
}

}  // namespace uwsim
