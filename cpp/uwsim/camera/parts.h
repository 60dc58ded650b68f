#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <iterator>
#include <thread>
#include <vector>

#include "uwsim/camera/kernel.h"

namespace uwsim {

/// Lanes that are set.
inline std::uint64_t count(const camera::Mask& mask) {
  return static_cast<std::uint64_t>(std::count(std::begin(mask.at), std::end(mask.at), -1));
}
inline bool any(const camera::Mask& mask) { return count(mask) > 0; }

/// Calls work(row, worker) for each row, handed out one by one; each must write to its own place only, so that it does
/// not matter who does which.
template <typename Work>
void for_rows(int rows, int threads, Work&& work) {
  std::atomic<int> next{0};
  const auto run = [&](int worker) {
    for (int row = next++; row < rows; row = next++) work(row, worker);
  };
  std::vector<std::jthread> others;
  for (int k = 1; k < std::min(threads, rows); ++k) others.emplace_back(run, k);
  run(0);
}

}  // namespace uwsim
