#pragma once

#include <algorithm>
#include <cstddef>

#include "uwsim/core/parallel.h"

namespace uwsim {

/// Calls work(row, worker) for each row on up to `threads` threads, which take rows one at a time. Each call must write
/// only to its own row, so that the result does not depend on which thread processes which row. An exception is
/// rethrown in the calling thread.
template <typename Work>
void for_rows(int rows, int threads, Work&& work) {
  parallel_batches(
      static_cast<std::size_t>(std::max(rows, 0)), 1, threads,
      [&](std::size_t row, std::size_t, std::size_t worker) { work(static_cast<int>(row), static_cast<int>(worker)); });
}

}  // namespace uwsim
