#include "uwsim/vehicle/battery.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace uwsim {
namespace {

constexpr std::uint64_t kStep_ns = 5'000'000;
constexpr double kStep_s = 0.005;
constexpr std::uint64_t kStart = 700;
constexpr std::array kVolts = {10.0, 14.0, 20.0};

Battery lasting_two_seconds() {
  Battery battery(2, kStep_ns);
  battery.start_mission(kStart);
  return battery;
}

/// A battery of 16 V when full and 12 V when empty, with 0.1 ohm.
BatterySpec cells() {
  BatterySpec spec;
  spec.capacity_ah = 1;
  spec.charges = {0, 1};
  spec.open_circuit_v = {12, 16};
  spec.resistance_ohm = 0.1;
  spec.cutoff_v = 11;
  return spec;
}

ElectricalLoad load(const std::array<double, 3>& currents_a) { return {kVolts, currents_a}; }

TEST(Battery, BeforeTheMissionItIsFullAndGivesNoPower) {
  Battery battery(2, kStep_ns);
  EXPECT_FALSE(battery.mission_started());
  EXPECT_FALSE(battery.supply(kStart, {}).on);
  EXPECT_EQ(battery.mission_time_s(kStart), 0);
  EXPECT_EQ(battery.charge_percent(kStart), 100);
}

TEST(Battery, ItDrainsEvenlyAndIsEmptyAtTheEndOfTheMission) {
  Battery battery = lasting_two_seconds();
  EXPECT_EQ(battery.charge_percent(kStart), 100);
  EXPECT_DOUBLE_EQ(battery.charge_percent(kStart + 100), 75);
  EXPECT_DOUBLE_EQ(battery.mission_time_s(kStart + 100), 0.5);
  EXPECT_TRUE(battery.supply(kStart + 399, {}).on);
  EXPECT_FALSE(battery.supply(kStart + 400, {}).on);
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

TEST(BatteryCells, TheVoltageSagsByResistanceTimesCurrent) {
  BatteryCells battery(cells());
  EXPECT_EQ(battery.rest().voltage_v, 16);
  EXPECT_NEAR(*battery.supply(load({20, 20, 20}), kStep_s).voltage_v, 16 - 0.1 * 20, 1e-12);
  EXPECT_NEAR(battery.current_a(), 20, 1e-12);
}

TEST(BatteryCells, ALoadThatFallsWithTheVoltageAndConstantPowerMeetAtOneVoltage) {
  for (const double hotel_w : {0.0, 1.0, 60.0}) {
    for (const double full_v : {13.0, 14.5, 19.0}) {
      BatterySpec spec = cells();
      spec.hotel_w = hotel_w;
      spec.open_circuit_v = {12, full_v};
      spec.cutoff_v = 10.2;
      const std::array currents = {4.0, 9.0, 30.0};
      BatteryCells battery(spec);
      const double v = *battery.supply(load(currents), kStep_s).voltage_v;
      ASSERT_FALSE(battery.empty());
      const double thrusters_a = v < 14 ? 4 + (v - 10) * 5 / 4 : 9 + (v - 14) * 21 / 6;
      EXPECT_NEAR(v, full_v - 0.1 * (thrusters_a + hotel_w / v), 1e-12);
      EXPECT_NEAR(battery.current_a(), thrusters_a + hotel_w / v, 1e-11);
    }
  }
}

TEST(BatteryCells, ChargeIsTheIntegralOfCurrentAndEnergyIsConserved) {
  BatteryCells battery(cells());
  const std::array currents = {2.0, 10.0, 40.0};
  double drawn_ah = 0, delivered_j = 0, lost_j = 0;
  for (int k = 0; k < 20'000; ++k) {
    const double v = *battery.supply(load(currents), kStep_s).voltage_v;
    drawn_ah += battery.current_a() * kStep_s / 3600;
    delivered_j += v * battery.current_a() * kStep_s;
    lost_j += 0.1 * battery.current_a() * battery.current_a() * kStep_s;
  }
  EXPECT_NEAR(battery.charge_ah(), 1 - drawn_ah, 1e-12);
  EXPECT_NEAR(battery.charge_percent(), 100 * (1 - drawn_ah), 1e-10);
  EXPECT_GT(drawn_ah, 0.2);
  const double s = battery.charge_ah();  // the cells supply the integral of E dq, with E = 12 + 4 s
  const double given_j = 3600 * (12 * (1 - s) + 2 * (1 - s * s));
  EXPECT_NEAR(delivered_j + lost_j, given_j, 1e-5 * given_j) << "but for the length of a step";
}

TEST(BatteryCells, BelowItsLowestVoltageItStaysOffUntilItIsCharged) {
  BatteryCells battery(cells());
  EXPECT_TRUE(battery.supply(load({49, 49, 49}), kStep_s).on) << "11.1 V";
  const Supply collapsed = battery.supply(load({51, 51, 51}), kStep_s);
  EXPECT_FALSE(collapsed.on);
  EXPECT_EQ(battery.current_a(), 0);
  EXPECT_EQ(battery.charge_percent(), 0);
  EXPECT_GT(battery.charge_ah(), 0.99);
  EXPECT_FALSE(battery.supply(load({0, 0, 0}), kStep_s).on);
  battery.charge_fully();
  EXPECT_TRUE(battery.supply(load({0, 0, 0}), kStep_s).on);
}

TEST(BatteryCells, AUsedUpChargeSwitchesOffEvenAtAHighVoltage) {
  BatterySpec spec = cells();
  spec.initial_charge = 1e-6;
  BatteryCells battery(spec);
  int steps = 0;
  while (battery.supply(load({0.36, 0.36, 0.36}), kStep_s).on && steps < 100) ++steps;
  EXPECT_EQ(steps, 2) << "1e-6 Ah are 3.6 mA s, 1.8 each step";
}

TEST(BatteryCells, ARestoredBatteryContinues) {
  BatteryCells battery(cells());
  const std::array currents = {2.0, 10.0, 40.0};
  for (int k = 0; k < 100; ++k) battery.supply(load(currents), kStep_s);
  StateArchive saved;
  battery.exchange_state(saved);
  BatteryCells other(cells());
  StateArchive restored(saved.bytes());
  other.exchange_state(restored);
  EXPECT_EQ(other.voltage_v(), battery.voltage_v());
  EXPECT_EQ(*other.supply(load(currents), kStep_s).voltage_v, *battery.supply(load(currents), kStep_s).voltage_v);
  EXPECT_EQ(other.charge_ah(), battery.charge_ah());
}

TEST(BatteryCells, InvalidOnesAreRefused) {
  const auto refused = [](auto change) {
    BatterySpec spec = cells();
    change(spec);
    EXPECT_THROW(BatteryCells{spec}, InvalidValue);
  };
  refused([](BatterySpec& s) { s.capacity_ah = 0; });
  refused([](BatterySpec& s) { s.open_circuit_v = {16, 12}; });
  refused([](BatterySpec& s) { s.charges = {0, 0.9}; });
  refused([](BatterySpec& s) { s.charges = {0}; });
  refused([](BatterySpec& s) { s.resistance_ohm = -1; });
  refused([](BatterySpec& s) { s.cutoff_v = 16; });
  refused([](BatterySpec& s) { s.hotel_w = 11 * 11 / 0.1; });
  refused([](BatterySpec& s) { s.initial_charge = NAN; });
}

}  // namespace
}  // namespace uwsim
