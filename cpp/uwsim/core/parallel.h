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

/// The number of threads that this machine can run concurrently, at least 1.
inline int usable_threads() { return static_cast<int>(std::max(1u, std::thread::hardware_concurrency())); }

/// Calls job(0), job(1), ... job(threads - 1), each on its own thread, with job(0) on the calling thread. Returns when
/// all have finished; rethrows the first exception.
template <typename Job>
void on_threads(std::size_t threads, const Job& job) {
  std::mutex mutex;
  std::exception_ptr error;
  const auto run = [&](std::size_t worker) {
    try {
      job(worker);
    } catch (...) {
      const std::scoped_lock lock(mutex);
      if (!error) error = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> others;
    others.reserve(threads - 1);
    for (std::size_t worker = 1; worker < threads; ++worker) {
      try {
        others.emplace_back(run, worker);
      } catch (const std::system_error&) {
        run(worker);  // the system cannot start another thread
      }
    }
    run(0);
  }
  if (error) std::rethrow_exception(error);
}

/// For items that all cost the same: calls work(first, last) on contiguous ranges that together cover [0, count). Uses
/// up to `threads` threads, with one range of at least `least_items` items each. Items must be independent, so that the
/// result does not depend on where the ranges are divided.
template <typename Work>
void parallel_ranges(std::size_t count, int threads, Work&& work, std::size_t least_items = 4096) {
  const std::size_t parts = std::clamp<std::size_t>(count / least_items, 1, std::max(threads, 1));
  on_threads(parts, [&](std::size_t part) { work(part * count / parts, (part + 1) * count / parts); });
}

/// For items whose costs differ: each thread takes the next `batch` items when it has finished its previous batch.
/// Calls work(first, last, worker); workers are numbered from 0, so that each can have its own scratch memory. An
/// exception stops the other threads after their current batch.
template <typename Work>
void parallel_batches(std::size_t count, std::size_t batch, int threads, Work&& work) {
  const std::size_t batches = (count + batch - 1) / batch;
  std::atomic<std::size_t> next{0};
  on_threads(std::clamp<std::size_t>(batches, 1, std::max(threads, 1)), [&](std::size_t worker) {
    try {
      for (std::size_t k = next++; k < batches; k = next++) work(k * batch, std::min(count, (k + 1) * batch), worker);
    } catch (...) {
      next = batches;  // the others stop after their current batch
      throw;
    }
  });
}

}  // namespace uwsim
