#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>
#include <vector>

#include "uwsim/core/parallel.h"

namespace uwsim {
namespace {

TEST(ParallelRanges, EveryItemIsProcessedOnce) {
  for (const std::size_t count : {0, 1, 7, 1000}) {
    std::vector<int> done(count, 0);
    parallel_ranges(
        count, 3,
        [&](std::size_t first, std::size_t last) {
          for (std::size_t i = first; i < last; ++i) ++done[i];
        },
        1);
    EXPECT_EQ(done, std::vector<int>(count, 1));
  }
}

TEST(ParallelBatches, EveryItemIsProcessedOnce) {
  for (const std::size_t count : {0, 1, 7, 1000}) {
    std::vector<int> done(count, 0);
    parallel_batches(count, 3, 3, [&](std::size_t first, std::size_t last, std::size_t) {
      for (std::size_t i = first; i < last; ++i) ++done[i];
    });
    EXPECT_EQ(done, std::vector<int>(count, 1));
  }
}

TEST(ParallelLoops, AnExceptionOnAnyThreadReachesTheCaller) {
  for (const std::size_t bad : {0, 50, 99}) {
    const auto work = [&](std::size_t first, std::size_t last) {
      if (first <= bad && bad < last) throw std::runtime_error("bad item");
    };
    EXPECT_THROW(parallel_ranges(100, 4, work, 1), std::runtime_error);
    const auto batch = [&](std::size_t first, std::size_t last, std::size_t) { work(first, last); };
    EXPECT_THROW(parallel_batches(100, 1, 4, batch), std::runtime_error);
  }
}

TEST(ParallelBatches, AnExceptionStopsTheOtherThreadsEarly) {
  std::atomic<int> done{0};
  const auto work = [&](std::size_t first, std::size_t, std::size_t) {
    if (first == 0) throw std::runtime_error("bad item");
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    ++done;
  };
  EXPECT_THROW(parallel_batches(1000, 1, 4, work), std::runtime_error);
  EXPECT_LT(done, 500);
}

}  // namespace
}  // namespace uwsim
