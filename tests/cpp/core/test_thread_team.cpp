#include <dlfcn.h>
#include <gtest/gtest.h>
#include <pthread.h>

#include <atomic>
#include <cerrno>
#include <stdexcept>
#include <vector>

#include "uwsim/core/thread_team.h"

namespace {

std::atomic<int> threads_left{1'000'000};  ///< number of threads that pthread_create below still allows

}  // namespace

/// Overrides the C library's function in this executable, to simulate a system that refuses to start more than a few
/// threads.
extern "C" int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*start)(void*),
                              void* argument) {
  static const auto real = reinterpret_cast<decltype(&pthread_create)>(dlsym(RTLD_NEXT, "pthread_create"));
  return threads_left-- > 0 ? real(thread, attributes, start, argument) : EAGAIN;
}

namespace uwsim {
namespace {

/// Adds one to each item in each of three phases, with `threads` threads; returns the items.
std::vector<int> add_in_three_phases(std::size_t threads) {
  std::vector<int> items(100, 0);
  std::atomic<std::size_t> next[3] = {};
  std::atomic<bool> in_order = true;
  ThreadTeam team(threads);
  team.run([&](std::size_t) {
    for (int phase = 0; phase < 3; ++phase) {
      const auto work = [&] {
        for (std::size_t i; (i = next[phase]++) < items.size();) {
          if (items[i]++ != phase) in_order = false;
        }
      };
      if (!team.phase(work)) return;
    }
  });
  EXPECT_TRUE(in_order);
  return items;
}

TEST(ThreadTeam, NoThreadStartsAPhaseBeforeAllHaveFinishedTheOneBefore) {
  for (const std::size_t threads : {1, 2, 5}) EXPECT_EQ(add_in_three_phases(threads), std::vector<int>(100, 3));
}

TEST(ThreadTeam, FewerThreadsThanAskedForStillDoAllTheWork) {
  for (const int available : {0, 1, 3}) {
    threads_left = available;
    EXPECT_EQ(add_in_three_phases(6), std::vector<int>(100, 3));
    EXPECT_LE(threads_left, available - 5) << "the system refused no thread";
    threads_left = 1'000'000;
  }
}

TEST(ThreadTeam, WhatAThreadThrowsInAPhaseEndsTheJobAndReachesTheCaller) {
  for (const std::size_t bad : {0, 1, 2}) {
    std::atomic<int> later_phases = 0;
    ThreadTeam team(3);
    const auto job = [&](std::size_t thread) {
      const auto work = [&] {
        if (thread == bad) throw std::runtime_error("bad item");
      };
      if (team.phase(work)) ++later_phases;
    };
    EXPECT_THROW(team.run(job), std::runtime_error);
    EXPECT_EQ(later_phases, 0);
  }
}

TEST(ThreadTeam, WhatAThreadThrowsBetweenPhasesLetsTheOthersEnd) {
  for (const std::size_t bad : {0, 2}) {
    ThreadTeam team(3);
    const auto job = [&](std::size_t thread) {
      if (thread == bad) throw std::runtime_error("bad thread");
      while (team.phase([] {})) {
      }
    };
    EXPECT_THROW(team.run(job), std::runtime_error);
  }
}

}  // namespace
}  // namespace uwsim
