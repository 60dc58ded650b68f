#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "uwsim/core/crew.h"

namespace uwsim {

/// The number of threads that this machine can run concurrently, at least 1.
inline int usable_threads() { return static_cast<int>(std::max(1u, std::thread::hardware_concurrency())); }

/// Calls job(part, worker) for each part in [0, parts), on up to `threads` threads. Each takes the parts of a share of
/// its own, in order, and then those that the others have left. A loop that is repeated over the same items thus finds
/// most of them in the cache of the core that used them last. Workers are numbered from 0, which is the calling thread.
/// Returns when all parts are done. An exception stops the other threads after their current part; the first one is
/// rethrown.
template <typename Job>
void parallel_parts(std::size_t parts, int threads, const Job& job) {
  const std::size_t workers = std::clamp<std::size_t>(parts, 1, static_cast<std::size_t>(std::max(threads, 1)));
  if (workers == 1) {
    for (std::size_t part = 0; part < parts; ++part) job(part, std::size_t{0});
    return;
  }
  struct alignas(64) Share {  // in a cache line of its own
    std::atomic<std::size_t> next;
    std::size_t end;
  };
  std::vector<Share> shares(workers);
  for (std::size_t k = 0; k < workers; ++k) {
    shares[k].next = k * parts / workers;
    shares[k].end = (k + 1) * parts / workers;
  }
  std::mutex mutex;
  std::exception_ptr error;
  Crew::shared().work(workers, [&](std::size_t worker) {
    try {
      for (std::size_t k = 0; k < workers; ++k) {
        Share& share = shares[(worker + k) % workers];
        for (std::size_t part = share.next++; part < share.end; part = share.next++) job(part, worker);
      }
    } catch (...) {
      for (Share& share : shares) share.next = share.end;
      const std::scoped_lock lock(mutex);
      if (!error) error = std::current_exception();
    }
  });
  if (error) std::rethrow_exception(error);
}

/// For items that all cost the same: calls work(first, last) on contiguous ranges that together cover [0, count). Uses
/// up to `threads` threads, with one range of at least `least_items` items each. Items must be independent, so that the
/// result does not depend on where the ranges are divided.
template <typename Work>
void parallel_ranges(std::size_t count, int threads, Work&& work, std::size_t least_items = 4096) {
  const std::size_t parts =
      std::clamp<std::size_t>(count / least_items, 1, static_cast<std::size_t>(std::max(threads, 1)));
  parallel_parts(parts, threads,
                 [&](std::size_t part, std::size_t) { work(part * count / parts, (part + 1) * count / parts); });
}

/// For items whose costs differ: a thread takes `batch` items at a time (see parallel_parts). Calls
/// work(first, last, worker); workers are numbered from 0, so that each can have its own scratch memory. An exception
/// stops the other threads after their current batch.
template <typename Work>
void parallel_batches(std::size_t count, std::size_t batch, int threads, Work&& work) {
  parallel_parts((count + batch - 1) / batch, threads, [&](std::size_t part, std::size_t worker) {
    work(part * batch, std::min(count, (part + 1) * batch), worker);
  });
}

}  // namespace uwsim
