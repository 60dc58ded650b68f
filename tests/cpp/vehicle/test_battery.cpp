#include "uwsim/vehicle/battery.h"

#include <gtest/gtest.h>

namespace uwsim {
namespace {

constexpr std::uint64_t kStep_ns = 5'000'000;
constexpr std::uint64_t kStart = 700;

Battery lasting_two_seconds() {
  Battery battery(2, kStep_ns);
  battery.start_mission(kStart);
  return battery;
}

TEST(Battery, BeforeTheMissionItIsFullAndGivesNoPower) {
  const Battery battery(2, kStep_ns);
  EXPECT_FALSE(battery.mission_started());
  EXPECT_FALSE(battery.has_power(kStart));
  EXPECT_EQ(battery.mission_time_s(kStart), 0);
  EXPECT_EQ(battery.charge_percent(kStart), 100);
}

TEST(Battery, ItDrainsEvenlyAndIsEmptyAtTheEndOfTheMission) {
  const Battery battery = lasting_two_seconds();
  EXPECT_EQ(battery.charge_percent(kStart), 100);
  EXPECT_DOUBLE_EQ(battery.charge_percent(kStart + 100), 75);
  EXPECT_DOUBLE_EQ(battery.mission_time_s(kStart + 100), 0.5);
  EXPECT_TRUE(battery.has_power(kStart + 399));
  EXPECT_FALSE(battery.has_power(kStart + 400));
  EXPECT_EQ(battery.charge_percent(kStart + 1000), 0);
}

TEST(Battery, ItsStateIsSavedAndRestored) {
  Battery battery = lasting_two_seconds();
  StateArchive saved;
  battery.exchange_state(saved, kStart);
  Battery other(2, kStep_ns);
  StateArchive restored(saved.bytes());
  other.exchange_state(restored, kStart);
  EXPECT_TRUE(other.mission_started());
  EXPECT_EQ(other.mission_time_s(kStart + 100), battery.mission_time_s(kStart + 100));
  StateArchive earlier(saved.bytes());
  EXPECT_THROW(other.exchange_state(earlier, kStart - 1), InvalidValue) << "a mission must not start in the future";
}

}  // namespace
}  // namespace uwsim
