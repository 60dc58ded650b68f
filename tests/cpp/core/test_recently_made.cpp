#include "uwsim/core/recently_made.h"

#include <gtest/gtest.h>

namespace uwsim {
namespace {

struct Maker {
  RecentlyMade<int> known;
  int made = 0;

  std::shared_ptr<const int> get(int wanted, bool is_worth_keeping = true) {
    return known.find_or_make(
        is_worth_keeping, [&](int object) { return object == wanted; },
        [&] { return ++made, std::make_shared<const int>(wanted); });
  }
};

TEST(RecentlyMade, TheSameIsMadeOnceForAllWhoUseIt) {
  Maker maker;
  const auto first = maker.get(1), other = maker.get(2);
  EXPECT_EQ(*other, 2);
  EXPECT_EQ(maker.get(1), first) << "in use, though another was made since";
  EXPECT_EQ(maker.made, 2);
}

TEST(RecentlyMade, OnlyTheLastIsKeptForTheNext) {
  Maker maker;
  maker.get(1);
  maker.get(1);
  EXPECT_EQ(maker.made, 1) << "kept, though nobody uses it";
  const std::weak_ptr<const int> first = maker.get(1), trifle = maker.get(3, false);
  EXPECT_TRUE(trifle.expired());
  EXPECT_FALSE(first.expired());
  maker.get(2);
  EXPECT_TRUE(first.expired());
}

TEST(RecentlyMade, WhatCannotBeMadeIsNotRemembered) {
  Maker maker;
  EXPECT_THROW(maker.known.find_or_make(
                   true, [](int) { return false; },
                   []() -> std::shared_ptr<const int> { throw std::runtime_error("no memory"); }),
               std::runtime_error);
  EXPECT_EQ(*maker.get(1), 1);
}

}  // namespace
}  // namespace uwsim
