#pragma once

#include <algorithm>
#include <cstddef>
#include <thread>
#include <vector>

namespace uwsim {

/// Calls work(first, last) on contiguous ranges that cover [0, count), on up to `threads` threads. Results must not
/// depend on where the ranges are cut: use it for independent items only. `worth_a_thread`: how many items are enough
/// work for one.
template <typename Work>
void parallel_ranges(std::size_t count, int threads, Work&& work, std::size_t worth_a_thread = 4096) {
  const std::size_t parts = std::clamp<std::size_t>(count / worth_a_thread, 1, std::max(threads, 1));
  std::vector<std::jthread> others;
  for (std::size_t part = 1; part < parts; ++part) {
    others.emplace_back([&, part] { work(part * count / parts, (part + 1) * count / parts); });
  }
  work(std::size_t{0}, count / parts);
}

}  // namespace uwsim
