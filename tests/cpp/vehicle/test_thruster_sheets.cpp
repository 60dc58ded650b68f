#include "uwsim/vehicle/thruster_sheets.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "uwsim/core/check.h"
#include "uwsim/vehicle/thruster.h"

namespace uwsim {
namespace {

const ThrusterSheet kLow{10, {-1, -0.1, 0.1, 1}, {-20, 0, 0, 30}, {12, 0, 0, 13}, {2000, 0, 0, 2500}};
const ThrusterSheet kHigh{20, {-1, 0, 1}, {-50, 0, 60}, {30, 0, 32}, {3000, 0, 3500}};

ThrusterParameters with_sheets() {
  ThrusterParameters p;
  p.name = "main";
  p.curve = ThrustCurve({-1, 1}, {-40, 40});
  p.sheets = ThrusterSheets({kLow, kHigh});
  p.time_constant_s = 0.1;
  return p;
}

TEST(ThrusterSheets, RootOfThrustAndSpeedAreLinearPerVolt) {
  const ThrusterSheets sheets({kLow, kHigh});
  for (const double v : {10.0, 12.5, 20.0}) {
    const double share = (v - 10) / 10;
    const ThrusterSheets::Point full = sheets.at(1, v), half = sheets.at(0.55, v), still = sheets.at(0.05, v);
    const double root = (1 - share) * std::sqrt(30) / 10 + share * std::sqrt(60) / 20;
    EXPECT_NEAR(full.thrust_n, std::pow(v * root, 2), 1e-12);
    EXPECT_NEAR(sheets.at(-1, v).thrust_n,
                -std::pow(v * ((1 - share) * std::sqrt(20) / 10 + share * std::sqrt(50) / 20), 2), 1e-12);
    EXPECT_NEAR(full.current_a, 13 + share * 19, 1e-12);
    EXPECT_NEAR(full.rpm, v * ((1 - share) * 250 + share * 175), 1e-9);
    EXPECT_NEAR(half.thrust_n, std::pow(v * ((1 - share) * std::sqrt(15) / 10 + share * std::sqrt(33) / 20), 2), 1e-12);
    EXPECT_NEAR(still.thrust_n, std::pow(v * share * std::sqrt(3) / 20, 2), 1e-12)
        << "the dead band narrows as the voltage rises";
  }
  EXPECT_THROW(sheets.at(1, 9.99), InvalidValue);
  EXPECT_THROW(sheets.at(1, 20.01), InvalidValue);
  EXPECT_THROW(ThrusterSheets().at(1, 12), InvalidValue);
}

TEST(ThrusterSheets, APropellerWhoseSpeedFollowsTheVoltageIsReproducedExactly) {
  const auto measured = [](double v) {
    return ThrusterSheet{v, {-1, 0, 1}, {-0.1 * v * v, 0, 0.2 * v * v}, {v, 0, v}, {150 * v, 0, 200 * v}};
  };
  const ThrusterSheets sheets({measured(10), measured(20)});
  EXPECT_NEAR(sheets.at(1, 14).thrust_n, 0.2 * 14 * 14, 1e-12);
  EXPECT_NEAR(sheets.at(-1, 14).thrust_n, -0.1 * 14 * 14, 1e-12);
  EXPECT_NEAR(sheets.at(1, 14).rpm, 200 * 14, 1e-9);
}

TEST(ThrusterSheets, InvalidOnesAreRefused) {
  EXPECT_THROW(ThrusterSheets({kLow}), InvalidValue) << "one voltage";
  EXPECT_THROW(ThrusterSheets({kHigh, kLow}), InvalidValue) << "falling voltages";
  const auto refused = [](auto change) {
    ThrusterSheet sheet = kLow;
    change(sheet);
    EXPECT_THROW(ThrusterSheets({sheet, kHigh}), InvalidValue);
  };
  refused([](ThrusterSheet& s) { s.commands[1] = -1; });
  refused([](ThrusterSheet& s) { s.commands[3] = 2; });
  refused([](ThrusterSheet& s) { s.thrusts_n[2] = 5; });
  refused([](ThrusterSheet& s) { s.thrusts_n.pop_back(); });
  refused([](ThrusterSheet& s) { s.currents_a[0] = -1; });
  refused([](ThrusterSheet& s) { s.rpm[0] = NAN; });
}

TEST(Thruster, ThrustAndCurrentApproachThoseOfTheSheetsAtTheSuppliedVoltage) {
  Thruster thruster(with_sheets());
  thruster.set_command(1);
  for (int k = 1; k <= 40; ++k) {
    std::array<double, 2> ahead_a{};
    thruster.add_current(0.005, ahead_a);
    thruster.advance(0.005, {true, 15.0});
    const double reached = 1 - std::exp(-0.005 * k / 0.1);
    EXPECT_NEAR(thruster.thrust_n(), ThrusterSheets({kLow, kHigh}).at(1, 15).thrust_n * reached, 1e-9);
    EXPECT_NEAR(thruster.current_a(), 22.5 * reached, 1e-9);
    EXPECT_NEAR(0.5 * (ahead_a[0] + ahead_a[1]), thruster.current_a(), 1e-9) << "as announced";
  }
  thruster.advance(0.005, {false, 15.0});
  EXPECT_EQ(thruster.current_a(), 0);
  EXPECT_GT(thruster.thrust_n(), 0) << "it spins down";
}

TEST(Thruster, WithoutASupplyVoltageSheetsHaveNoEffect) {
  Thruster thruster(with_sheets());
  thruster.set_command(0.5);
  for (int k = 0; k < 2000; ++k) thruster.advance(0.005, {true, {}});
  EXPECT_NEAR(thruster.thrust_n(), 20, 1e-12);
  EXPECT_EQ(thruster.current_a(), 0);
}

TEST(Thruster, AFaultTakesItsShareOfThrustAndCurrent) {
  ThrusterParameters p = with_sheets();
  p.health = 0.5;
  p.time_constant_s = 0;
  Thruster thruster(p);
  thruster.set_command(1);
  thruster.advance(0.005, {true, 10.0});
  EXPECT_NEAR(thruster.thrust_n(), 15, 1e-12);
  EXPECT_NEAR(thruster.current_a(), 6.5, 1e-12);
}

}  // namespace
}  // namespace uwsim
