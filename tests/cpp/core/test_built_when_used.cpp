#include "uwsim/core/built_when_used.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <thread>
#include <vector>

namespace uwsim {
namespace {

TEST(BuiltWhenUsed, ThreadsThatUseItAtOnceShareOnePart) {
  const BuiltWhenUsed<std::vector<int>> part;
  std::atomic<int> builds = 0;
  std::vector<const std::vector<int>*> used(8);
  {
    std::vector<std::jthread> threads;
    for (auto& each : used) {
      threads.emplace_back([&] {
        each = &part.get([&] {
          ++builds;
          std::this_thread::sleep_for(std::chrono::milliseconds(20));
          return std::vector<int>{7};
        });
      });
    }
  }
  EXPECT_EQ(builds, 1);
  for (const auto* each : used) EXPECT_EQ(each, used.front());
  EXPECT_EQ(*used.front(), std::vector<int>{7});
}

TEST(BuiltWhenUsed, AFailedBuildIsTriedAgain) {
  const BuiltWhenUsed<int> part;
  EXPECT_THROW(part.get([]() -> int { throw std::runtime_error("no memory"); }), std::runtime_error);
  EXPECT_EQ(part.get([] { return 3; }), 3);
}

}  // namespace
}  // namespace uwsim
