#pragma once

#include <algorithm>
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

}  // namespace uwsim
