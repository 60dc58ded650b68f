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

}  // namespace
}  // namespace uwsim
