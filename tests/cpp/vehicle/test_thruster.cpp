#include "uwsim/vehicle/thruster.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

const ThrustCurve kDeadBand({-1, -0.1, 0.1, 1}, {-40, 0, 0, 50});

ThrusterParameters pusher() {
  ThrusterParameters p;
  p.name = "main";
  p.position_body_m = {-0.5, 0.2, 0};
  p.curve = kDeadBand;
  p.time_constant_s = 0.2;
  return p;
}

Vector6d wrench(const Thruster& thruster, const Vector6d& through_water = Vector6d::Zero()) {
  Vector6d tau = Vector6d::Zero();
  thruster.add_wrench(through_water, 1000, 1, tau);
  return tau;
}

/// A thruster that is already at full thrust ahead.
Thruster running(ThrusterParameters p) {
  p.time_constant_s = 0;
  Thruster thruster(p);
  thruster.set_command(1);
  thruster.advance(0.005, {true, {}});
  return thruster;
}

TEST(ThrustCurve, ItPassesThroughItsPointsAndCanBeInverted) {
  EXPECT_EQ(kDeadBand.thrust_n(-1), -40);
  EXPECT_EQ(kDeadBand.thrust_n(1), 50);
  EXPECT_EQ(kDeadBand.thrust_n(0.05), 0) << "inside the dead band";
  EXPECT_NEAR(kDeadBand.thrust_n(0.55), 25, 1e-12);
  for (const double thrust : {-40.0, -13.0, -1e-6, 0.0, 1e-6, 20.0, 50.0}) {
    EXPECT_NEAR(kDeadBand.thrust_n(kDeadBand.command(thrust)), thrust, 1e-12);
  }
  EXPECT_EQ(kDeadBand.command(0), 0);
  EXPECT_EQ(kDeadBand.command(70), 1) << "saturated";
  EXPECT_EQ(kDeadBand.command(-70), -1);
}

TEST(ThrustCurve, InvalidTablesAreRefused) {
  EXPECT_THROW(ThrustCurve({0}, {0}), InvalidValue);
  EXPECT_THROW(ThrustCurve({-1, 1}, {-1, 1, 2}), InvalidValue);
  EXPECT_THROW(ThrustCurve({-1, 0, 0, 1}, {-1, 0, 0, 1}), InvalidValue) << "a repeated command";
  EXPECT_THROW(ThrustCurve({-1, 0, 1}, {1, 0, -1}), InvalidValue) << "thrust falls";
  EXPECT_THROW(ThrustCurve({-1, 1}, {-1, 2}), InvalidValue) << "thrust at command 0";
  EXPECT_THROW(ThrustCurve({-1, 0, 1.5}, {-1, 0, 1}), InvalidValue);
  EXPECT_THROW(ThrustCurve({-1, 0, 1}, {-1, 0, NAN}), InvalidValue);
}

TEST(Thruster, ItFollowsWithItsTimeConstantWhateverTheStep) {
  for (const int steps : {1, 4, 1000}) {
    Thruster thruster(pusher());
    thruster.set_command(1);
    double impulse = 0;
    for (int k = 0; k < steps; ++k) {
      thruster.advance(0.2 / steps, {true, {}});
      impulse += wrench(thruster)(0) * 0.2 / steps;
    }
    EXPECT_NEAR(thruster.thrust_n(), 50 * (1 - std::exp(-1)), 1e-10);
    EXPECT_NEAR(impulse, 50 * 0.2 * std::exp(-1), 1e-10) << "the wrench is the mean over the step";
  }
}

TEST(Thruster, AnIdleThrusterReachesZeroAndIsNeverSubnormal) {
  Thruster thruster(pusher());
  thruster.set_command(1);
  for (int k = 0; k < 200; ++k) thruster.advance(0.005, {true, {}});
  thruster.set_command(0);
  for (int k = 0; k < 60'000; ++k) {  // 5 min; the exponential would be subnormal after 143 s
    thruster.advance(0.005, {true, {}});
    ASSERT_NE(std::fpclassify(thruster.thrust_n()), FP_SUBNORMAL) << "after " << k << " steps";
    ASSERT_NE(std::fpclassify(wrench(thruster)(0)), FP_SUBNORMAL) << "after " << k << " steps";
  }
  EXPECT_EQ(thruster.thrust_n(), 0);
}

TEST(Thruster, WithoutPowerItSpinsDown) {
  Thruster thruster = running(pusher());
  thruster.advance(0.005, {});
  EXPECT_EQ(thruster.thrust_n(), 0);
}

TEST(Thruster, ForceActsAtTheHubAndTorqueAgainstTheSpin) {
  ThrusterParameters p = pusher();
  p.torque_per_thrust_m = 0.02;
  for (const int spin : {1, -1}) {
    p.spin = spin;
    Thruster thruster = running(p);
    Vector6d expected;
    expected << 50, 0, 0, -spin * 50 * 0.02, 0, -0.2 * 50;
    EXPECT_LT((wrench(thruster) - expected).norm(), 1e-12);
    thruster.set_command(-1);
    thruster.advance(0.005, {true, {}});
    EXPECT_LT((wrench(thruster) + 0.8 * expected).norm(), 1e-12) << "astern the torque is reversed";
  }
}

TEST(Thruster, ThrustFallsLinearlyWithInflowToZeroAtTheAdvanceRatio) {
  ThrusterParameters p = pusher();
  p.diameter_m = 0.076;
  p.bollard_coefficient = 0.44;
  p.zero_thrust_advance_ratio = 0.9;
  const Thruster thruster = running(p);
  const double revolutions_s = std::sqrt(50 / (1000 * 0.44 * std::pow(0.076, 4)));
  const double zero_thrust_m_s = 0.9 * revolutions_s * 0.076;
  for (const double share : {-0.3, 0.0, 0.5, 1.0}) {
    Vector6d moving = Vector6d::Zero();
    moving(0) = share * zero_thrust_m_s;
    moving(1) = 2;  // across the axis: no effect
    EXPECT_NEAR(wrench(thruster, moving)(0), 50 * (1 - share), 1e-9);
  }
  Vector6d turning = Vector6d::Zero();
  turning(5) = -zero_thrust_m_s / 0.2;  // the hub, 0.2 m to port, moves ahead
  EXPECT_NEAR(wrench(thruster, turning)(0), 0, 1e-9);
  EXPECT_NEAR(wrench(running(pusher()), turning)(0), 50, 1e-12) << "no loss where none is given";
}

TEST(Thruster, TheDiscSubmergesContinuously) {
  const Thruster thruster(pusher());  // disc of 0.1 m across a level axis
  EXPECT_EQ(thruster.submerged_fraction(0.05, 0), 1);
  EXPECT_EQ(thruster.submerged_fraction(-0.05, 0), 0);
  EXPECT_NEAR(thruster.submerged_fraction(0, 0), 0.5, 1e-12);
  const double segment = std::numbers::pi / 3 - std::sqrt(3) / 4;  // of a unit circle, cut at half its radius
  EXPECT_NEAR(thruster.submerged_fraction(-0.025, 0), segment / std::numbers::pi, 1e-12);
  EXPECT_EQ(thruster.submerged_fraction(0.001, 1), 1) << "a level disc is wet or dry";
}

TEST(Thruster, InvalidParametersAreRefused) {
  const auto refused = [](auto change) {
    ThrusterParameters p = pusher();
    change(p);
    EXPECT_THROW(Thruster{p}, InvalidValue);
  };
  refused([](ThrusterParameters& p) { p.axis_body = {1, 1, 0}; });
  refused([](ThrusterParameters& p) { p.time_constant_s = -1; });
  refused([](ThrusterParameters& p) { p.diameter_m = 0; });
  refused([](ThrusterParameters& p) { p.zero_thrust_advance_ratio = 0; });
  refused([](ThrusterParameters& p) { p.position_body_m.x() = NAN; });
  refused([](ThrusterParameters& p) { p.spin = 0; });
}

}  // namespace
}  // namespace uwsim
