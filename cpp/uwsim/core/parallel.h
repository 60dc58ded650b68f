#pragma once

#include <algorithm>
#include <cstddef>
#include <thread>
#include <vector>

namespace uwsim {

/// Calls work(first, last) on contiguous ranges that cover [0, count), on up to `threads` threads. Results must not
/// depend on where the ranges are cut: use it for independent items only.
template <typename Work>
void parallel_ranges(std::size_t count, int threads, Work&& work) {
  constexpr std::size_t kWorthAThread = 4096;
  const std::size_t parts = std::clamp<std::size_t>(count / kWorthAThread, 1, std::max(threads, 1));
  std::vector<std::jthread> others;
  for (std::size_t part = 1; part < parts; ++part) {
    others.emplace_back([&, part] { work(part * count / parts, (part + 1) * count / parts); });
  }
  work(std::size_t{0}, count / parts);
}

}  // namespace uwsim
