#include "uwsim/control/control_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>

#include "meshes.h"

namespace uwsim {
namespace {

constexpr double kDensity_kg_m3 = 1000;

std::shared_ptr<const Craft> box() {
  const SolidProperties solid = solid_properties(testing::box(0.6, 0.5, 0.3));
  CraftParameters p;
  p.mass_kg = 1.02 * kDensity_kg_m3 * solid.volume_m3;  // negatively buoyant
  p.inertia_kg_m2 = kDensity_kg_m3 * solid.inertia_per_density_m5;
  p.centre_of_mass_body_m = {0, 0, -0.02};
  p.added_mass.diagonal() << 20, 40, 60, 1, 2, 3;
  p.linear_damping.diagonal() << 10, 12, 14, 1, 1, 1;
  p.quadratic_damping.diagonal() << 40, 80, 120, 2, 2, 2;
  return std::make_shared<const Craft>(p, BuoyantHull(testing::box(0.6, 0.5, 0.3)));
}

/// Actuators that produce forces and torques along the body axes directly.
ActuatorsSpec direct(const Vector6d& full_wrench_body) {
  ActuatorsSpec spec;
  spec.full_wrench_body = full_wrench_body;
  return spec;
}

/// Four horizontal thrusters of 50 N at 45 degrees around the middle, and a vertical one.
ControlModel vectored() {
  ActuatorsSpec spec;
  for (int k = 0; k < 5; ++k) {
    const double left = k % 2 ? 1 : -1, ahead = k < 2 ? 1 : -1;
    ThrusterParameters thruster;
    thruster.name = "thruster_" + std::to_string(k);
    thruster.curve = ThrustCurve({-1, 1}, {-50, 50});
    if (k < 4) {
      thruster.position_body_m = {0.2 * ahead, 0.15 * left, 0};
      thruster.axis_body = Eigen::Vector3d(1, -ahead * left, 0).normalized();
    } else {
      thruster.axis_body = Eigen::Vector3d::UnitZ();
    }
    spec.thrusters.push_back(thruster);
  }
  return {box(), spec, kDensity_kg_m3};
}

Vector6d six(double surge, double sway, double heave, double roll, double pitch, double yaw) {
  return (Vector6d() << surge, sway, heave, roll, pitch, yaw).finished();
}

/// The simulated vehicle responds to the wrench with exactly the requested acceleration.
TEST(ControlModel, ItsWrenchGivesTheAcceleration) {
  const ControlModel model(box(), direct(Vector6d::Constant(1000)), kDensity_kg_m3);
  const Eigen::Quaterniond tilted(Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, 3).normalized()));
  const Vector6d velocity = six(1, -0.4, 0.3, 0.2, -0.1, 0.5), wanted = six(0.5, 0.1, -0.2, 0.3, 0.2, -0.4);
  const Vector6d wrench = model.wrench_body(tilted.toRotationMatrix(), velocity, wanted);
  EvenWater water;
  water.density_kg_m3 = kDensity_kg_m3;
  const BodyState state{{{0, 0, -50}, tilted}, velocity};
  EXPECT_LT((box()->acceleration_body(state, wrench, water, 0) - wanted).norm(), 1e-9);
  const Vector6d other = model.wrench_body(tilted.toRotationMatrix(), velocity, wanted + velocity);
  EXPECT_LT((model.change_body(other - wrench) - velocity).norm(), 1e-9);
}

TEST(ControlModel, ADirectWrenchIsLimitedAxisByAxis) {
  const Vector6d full = six(100, 50, 0, 0, 0, 10);
  const ControlModel model(box(), direct(full), kDensity_kg_m3);
  EXPECT_EQ(model.driven(), (std::array{true, true, false, false, false, true}));
  const Vector6d given = model.reachable(six(200, -25, 40, 3, 3, -40), 0);
  EXPECT_EQ(given, six(100, -25, 0, 0, 0, -10));
  EXPECT_EQ(model.effort(given, 0), six(1, -0.5, 0, 0, 0, -1));
}

TEST(ControlModel, TorqueComesFirstAndForceKeepsItsDirection) {
  const ControlModel model = vectored();
  const Vector6d wanted = six(300, 200, 0, 0, 0, 5), given = model.reachable(wanted, 0);
  EXPECT_NEAR(given[5], wanted[5], 1e-9);
  EXPECT_NEAR(given[0] * wanted[1], given[1] * wanted[0], 1e-6);
  EXPECT_GT(given[0], 0);
  EXPECT_LT(given[0], wanted[0]);
  const Vector6d small = six(20, -10, 15, 0, 0, 1);
  EXPECT_LT((model.reachable(small, 0) - small).norm(), 1e-12);
}

TEST(ControlModel, AcrossFirstGivesUpForceAhead) {
  const ControlModel model = vectored();
  const Vector6d wanted = six(300, 60, 0, 0, 0, 5);
  const Vector6d plain = model.reachable(wanted, 0), across = model.reachable(wanted, 0, true);
  EXPECT_LT(plain[1], wanted[1] - 1);
  EXPECT_NEAR(across[1], wanted[1], 1e-9);
  EXPECT_NEAR(across[5], wanted[5], 1e-9);
  EXPECT_LT(across[0], plain[0]);
  EXPECT_GT(across[0], 0);
}

/// The torque of fins is proportional to the square of the speed ahead; below 0.3 m/s, the model uses the torque at 0.3
/// m/s.
TEST(ControlModel, AFinsTorqueGrowsWithTheSquareOfTheSpeed) {
  ActuatorsSpec spec = direct(six(50, 0, 0, 0, 0, 0));
  FinParameters rudder;
  rudder.name = "rudder";
  rudder.position_body_m = {-0.5, 0, 0};
  rudder.span_body = Eigen::Vector3d::UnitZ();
  rudder.deflection_max_rad = 0.3;
  spec.fins.push_back(rudder);
  const ControlModel model(box(), spec, kDensity_kg_m3);
  EXPECT_TRUE(model.driven()[5]);
  const auto torque = [&](double surge_m_s) { return model.reachable(six(0, 0, 0, 0, 0, 1e6), surge_m_s)[5]; };
  EXPECT_GT(torque(1), 0);
  EXPECT_NEAR(torque(2) / torque(1), 4, 1e-9);
  EXPECT_EQ(torque(0), torque(0.3));
  const Vector6d full = model.effort(six(0, 0, 0, 0, 0, torque(1)), 1);
  EXPECT_NEAR(std::abs(full[5]), 1, 1e-9);
  EXPECT_NEAR(model.effort(six(0, 0, 0, 0, 0, torque(1)), 2)[5] / full[5], 0.25, 1e-9);
}

}  // namespace
}  // namespace uwsim
