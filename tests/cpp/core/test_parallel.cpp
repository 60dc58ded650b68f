#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
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

TEST(ParallelBatches, ALoopEndsWithoutAThreadThatIsBusyElsewhere) {
  // The first loop occupies its threads until the second one, on this thread, has ended.
  std::atomic<bool> is_occupied{false}, may_end{false};
  std::jthread first([&] {
    parallel_batches(2, 1, 2, [&](std::size_t, std::size_t, std::size_t) {
      is_occupied = true;
      while (!may_end) std::this_thread::yield();
    });
  });
  while (!is_occupied) std::this_thread::yield();
  std::atomic<int> done{0};
  parallel_batches(100, 1, 2, [&](std::size_t, std::size_t, std::size_t) { ++done; });
  EXPECT_EQ(done, 100);
  may_end = true;
}

TEST(ParallelBatches, LoopsMayBeNested) {
  std::atomic<int> done{0};
  parallel_batches(8, 1, 4, [&](std::size_t, std::size_t, std::size_t) {
    parallel_batches(8, 1, 4, [&](std::size_t, std::size_t, std::size_t) { ++done; });
  });
  EXPECT_EQ(done, 64);
}

TEST(ParallelBatches, WorkersAreNumberedApart) {
  for (int turn = 0; turn < 100; ++turn) {
    std::array<std::atomic<int>, 3> inside{};
    parallel_batches(30, 1, 3, [&](std::size_t, std::size_t, std::size_t worker) {
      ASSERT_LT(worker, inside.size());
      EXPECT_EQ(++inside.at(worker), 1);
      --inside.at(worker);
    });
  }
}

TEST(ParallelBatches, AForkedChildHasThreadsOfItsOwn) {
  const auto sum = [] {
    std::atomic<int> done{0};
    parallel_batches(100, 1, 3, [&](std::size_t, std::size_t, std::size_t) { ++done; });
    return done.load();
  };
  EXPECT_EQ(sum(), 100);
  const pid_t child = fork();
  if (child == 0) _exit(sum() == 100 ? 0 : 1);
  int status = -1;
  waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
}

}  // namespace
}  // namespace uwsim
