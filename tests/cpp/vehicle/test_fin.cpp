#include "uwsim/vehicle/fin.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

/// A fin to port, with its centre of pressure at the origin.
FinParameters plane() {
  FinParameters p;
  p.name = "port";
  p.area_m2 = 0.01;
  p.aspect_ratio = 2;
  p.parasitic_drag = 0.01;
  p.stall_angle_rad = 20 * kDegree;
  p.deflection_max_rad = 30 * kDegree;
  return p;
}

/// (Upward lift, drag) on a fin that moves at 2 m/s, ahead and downward, with an angle of attack of `attack_rad`.
Eigen::Vector2d lift_and_drag(const Fin& fin, double attack_rad) {
  Vector6d moving = Vector6d::Zero();
  moving(0) = 2 * std::cos(attack_rad);
  moving(2) = -2 * std::sin(attack_rad);
  Vector6d tau = Vector6d::Zero();
  fin.add_wrench(moving, 1000, 1, tau);
  const double c = std::cos(attack_rad), s = std::sin(attack_rad);
  return {s * tau(0) + c * tau(2), -c * tau(0) + s * tau(2)};
}

TEST(Fin, TheLiftSlopeIsThatOfALowAspectRatioWing) {
  FinParameters p = plane();
  EXPECT_NEAR(p.lift_slope(), 2 * std::numbers::pi / (1 + std::numbers::sqrt2), 1e-12);
  p.aspect_ratio = 1e6;
  EXPECT_NEAR(p.lift_slope(), 2 * std::numbers::pi, 1e-4) << "a wing of infinite span";
  p.aspect_ratio = 0.01;
  EXPECT_NEAR(p.lift_slope(), 0.01 * std::numbers::pi / 2, 1e-6) << "a slender body";
  const double pressure_area = 0.5 * 1000 * 4 * 0.01, angle = 0.01;
  const Eigen::Vector2d force = lift_and_drag(Fin(plane()), angle) / pressure_area;
  EXPECT_NEAR(force(0) / angle, plane().lift_slope(), 2e-3);
  EXPECT_NEAR(force(1), 0.01 + std::pow(force(0), 2) / (std::numbers::pi * 0.9 * 2), 1e-5) << "induced drag";
}

TEST(Fin, BeyondStallItIsAFlatPlate) {
  const Fin fin(plane());
  double largest = 0, at = 0;
  for (double angle = 0; angle < 30 * kDegree; angle += 0.1 * kDegree) {
    const double lift = fin.coefficients(angle).lift;
    if (lift > largest) {
      largest = lift;
      at = angle;
    }
  }
  EXPECT_LT(fin.coefficients(28 * kDegree).lift, 0.8 * largest) << "lift must drop beyond stall";
  EXPECT_NEAR(at, 15 * kDegree, 3 * kDegree);
  const Fin::Coefficients plate = fin.coefficients(70 * kDegree);
  EXPECT_NEAR(plate.lift, 2 * std::pow(std::sin(70 * kDegree), 2) * std::cos(70 * kDegree), 1e-6);
  EXPECT_NEAR(plate.drag, 0.01 + 2 * std::pow(std::sin(70 * kDegree), 3), 1e-5);
  EXPECT_NEAR(fin.coefficients(-0.1).lift, -fin.coefficients(0.1).lift, 1e-15);
}

TEST(Fin, DragOpposesTheMotionAtEveryAngleOfAttack) {
  const Fin fin(plane());
  for (double angle = -180 * kDegree; angle < 180 * kDegree; angle += 5 * kDegree) {
    EXPECT_GT(lift_and_drag(fin, angle)(1), 0) << angle;
  }
}

TEST(Fin, ADeflectionChangesTheAngleOfAttack) {
  Fin fin(plane());
  fin.set_command(-5 * kDegree);  // about +y: the leading edge rises
  fin.advance(10);
  EXPECT_NEAR(lift_and_drag(fin, 0)(0), lift_and_drag(Fin(plane()), 5 * kDegree)(0), 1e-9);
  EXPECT_NEAR(lift_and_drag(fin, -5 * kDegree)(0), 0, 1e-9) << "turned into the flow";
  const Eigen::Vector3d per_radian = 0.5 * 1000 * 4 * fin.column().head<3>();
  Fin slightly(plane());
  slightly.set_command(1e-4);
  slightly.advance(10);
  EXPECT_NEAR(lift_and_drag(slightly, 0)(0), 1e-4 * per_radian.z(), 1e-5);
}

TEST(Fin, ItTurnsAtItsLimitedRate) {
  FinParameters p = plane();
  p.rate_max_rad_s = 0.5;
  Fin fin(p);
  fin.set_command(0.3);
  fin.advance(0.2);
  EXPECT_NEAR(fin.angle_rad(), 0.1, 1e-12);
  for (int k = 0; k < 10; ++k) fin.advance(0.2);
  EXPECT_NEAR(fin.angle_rad(), 0.3, 1e-12);
}

TEST(Fin, AtTheSternItDampsTurning) {
  FinParameters p = plane();
  p.position_body_m = {-0.7, 0, 0.1};
  p.span_body = Eigen::Vector3d::UnitZ();
  const Fin rudder(p);
  Vector6d moving = Vector6d::Zero(), tau = Vector6d::Zero();
  moving(0) = 1.5;
  moving(5) = 0.1;
  rudder.add_wrench(moving, 1000, 1, tau);
  EXPECT_LT(tau(5), 0);
  const double lift = 0.5 * 1000 * 0.01 * 1.5 * p.lift_slope() * 0.07;  // q A C_La (0.07 m/s / 1.5 m/s)
  EXPECT_NEAR(tau(1), lift, 0.02 * lift) << "the tail swings to starboard; lift pushes it back to port";
  EXPECT_NEAR(tau(5), -0.7 * tau(1), 1e-12);
  tau.setZero();
  rudder.add_wrench(Vector6d::Zero(), 1000, 1, tau);
  EXPECT_TRUE(tau.isZero(0));
}

TEST(Fin, InvalidParametersAreRefused) {
  const auto refused = [](auto change) {
    FinParameters p = plane();
    change(p);
    EXPECT_THROW(Fin{p}, InvalidValue);
  };
  refused([](FinParameters& p) { p.area_m2 = 0; });
  refused([](FinParameters& p) { p.aspect_ratio = NAN; });
  refused([](FinParameters& p) { p.span_body = Eigen::Vector3d::UnitX(); });
  refused([](FinParameters& p) { p.deflection_max_rad = 2; });
  refused([](FinParameters& p) { p.rate_max_rad_s = 0; });
}

constexpr double kWater = 1000, kThrust = 100, kRadius = 0.1;
constexpr double kDisc = std::numbers::pi * kRadius * kRadius;

/// The jet of a propeller at the origin, this far behind it.
Slipstream jet_at(double behind_m, double inflow_m_s, double thrust_n = kThrust) {
  return Slipstream::behind(thrust_n, inflow_m_s, kWater, kRadius, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitX(),
                            {-behind_m, 0, 0});
}

TEST(Slipstream, KeepsMassAndCarriesTheThrust) {
  for (const double inflow : {-0.5, 0.0, 1.0, 3.0}) {
    const double at_disc = inflow + jet_at(0, inflow).velocity_body_m_s.x();
    EXPECT_NEAR(jet_at(0, inflow).radius_m, kRadius, 1e-12);
    const Slipstream far = jet_at(1e4, inflow);
    const double faster = far.velocity_body_m_s.x(), flow = kWater * kDisc * at_disc;
    EXPECT_NEAR(flow * faster, kThrust, 1e-6) << "momentum that the water gains each second";
    EXPECT_NEAR(kWater * std::numbers::pi * far.radius_m * far.radius_m * (inflow + faster), flow, 1e-6);
    EXPECT_NEAR(faster, 2 * (at_disc - inflow), 1e-6) << "half of it at the disc";
  }
  EXPECT_EQ(jet_at(0.2, 1.0, 0).radius_m, 0) << "no thrust";
  EXPECT_EQ(jet_at(0.2, 1.0, -kThrust).radius_m, 0) << "the jet goes the other way";
}

TEST(Slipstream, MeetsTheSpanWhereItIs) {
  const Slipstream jet = jet_at(1e4, 0);  // of 1 / sqrt(2) of the disc's radius
  const double r = kRadius / std::numbers::sqrt2;
  const auto share = [&](double y, double z, double length) {
    return jet.share_of({-1, y, z}, Eigen::Vector3d::UnitZ(), length);
  };
  EXPECT_NEAR(share(0, 0, 4 * r), 0.5, 1e-6);
  EXPECT_NEAR(share(0, 0, r), 1, 1e-6);
  EXPECT_NEAR(share(0, r, 2 * r), 0.5, 1e-6) << "one half above it";
  EXPECT_NEAR(share(0.6 * r, 0, 4 * r), 0.4, 1e-6) << "a chord of 1.6 radii";
  EXPECT_EQ(share(1.1 * r, 0, r), 0);
}

/// A rudder 0.2 m behind the propeller, its deflection reached.
Fin rudder(double angle_rad) {
  FinParameters p = plane();
  p.name = "rudder";
  p.position_body_m = {-0.2, 0, 0};
  p.span_body = Eigen::Vector3d::UnitZ();
  Fin fin(p);
  fin.set_command(angle_rad);
  fin.advance(10);
  return fin;
}

TEST(Rudder, ActsInTheJetAloneAtBollardPull) {
  for (const double side : {-1.0, 1.0}) {
    const Fin fin = rudder(side * 10 * kDegree);
    Vector6d still = Vector6d::Zero();
    fin.add_wrench(Vector6d::Zero(), kWater, 1, jet_at(0.2, 0, 0), still);
    EXPECT_TRUE(still.isZero(0)) << "neither speed nor thrust";
    const Slipstream jet = jet_at(0.2, 0);
    const double speed = jet.velocity_body_m_s.x();
    const double pressure_area =
        0.5 * kWater * speed * speed * 0.01 * jet.share_of({-0.2, 0, 0}, Eigen::Vector3d::UnitZ(), std::sqrt(0.02));
    Vector6d tau = Vector6d::Zero();
    fin.add_wrench(Vector6d::Zero(), kWater, 1, jet, tau);
    const Fin::Coefficients c = fin.coefficients(10 * kDegree);
    EXPECT_NEAR(tau(1), side * pressure_area * c.lift, 1e-9) << "a positive deflection pushes the stern to port";
    EXPECT_NEAR(tau(0), -pressure_area * c.drag, 1e-9);
    EXPECT_NEAR(tau(5), -0.2 * tau(1), 1e-9) << "and turns the vehicle to starboard";
  }
}

TEST(Rudder, IsAFinWhereThereIsNoJet) {
  const Fin fin = rudder(10 * kDegree);
  Vector6d moving = Vector6d::Zero();
  moving << 2, 0.1, 0, 0, 0, 0.2;
  Vector6d alone = Vector6d::Zero(), behind = Vector6d::Zero(), pushed = Vector6d::Zero();
  fin.add_wrench(moving, kWater, 1, alone);
  fin.add_wrench(moving, kWater, 1, jet_at(0.2, 2, -kThrust), behind);
  EXPECT_TRUE(behind.isApprox(alone, 1e-12));
  fin.add_wrench(moving, kWater, 1, jet_at(0.2, 2), pushed);
  EXPECT_GT(std::abs(pushed(1)), 1.5 * std::abs(alone(1)));
}

}  // namespace
}  // namespace uwsim
