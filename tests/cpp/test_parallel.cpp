#include <gtest/gtest.h>

#include <stdexcept>
#include <vector>

#include "uwsim/core/parallel.h"

namespace uwsim {
namespace {

TEST(ParallelRanges, EveryItemIsDoneOnce) {
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

TEST(ParallelShares, EveryItemIsDoneOnce) {
  for (const std::size_t count : {0, 1, 7, 1000}) {
    std::vector<int> done(count, 0);
    parallel_shares(count, 3, 3, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) ++done[i];
    });
    EXPECT_EQ(done, std::vector<int>(count, 1));
  }
}

TEST(ParallelRanges, WhatAThreadThrowsIsThrownHere) {
  for (const std::size_t bad : {0, 50, 99}) {
    const auto work = [&](std::size_t first, std::size_t last) {
      if (first <= bad && bad < last) throw std::runtime_error("bad item");
    };
    EXPECT_THROW(parallel_ranges(100, 4, work, 1), std::runtime_error);
    EXPECT_THROW(parallel_shares(100, 1, 4, work), std::runtime_error);
  }
}

}  // namespace
}  // namespace uwsim
