#include "uwsim/vehicle/hydrodynamics.h"

#include <gtest/gtest.h>

#include <cmath>

#include "meshes.h"
#include "uwsim/core/check.h"

namespace uwsim {
namespace {

CraftParameters neutral_box() {
  const SolidProperties solid = solid_properties(testing::box(1.2, 0.8, 0.6));
  CraftParameters p;
  p.mass_kg = 1000 * solid.volume_m3;
  p.inertia_kg_m2 = 1000 * solid.inertia_per_density_m5;
  return p;
}

BodyState deep(const Eigen::Quaterniond& orientation = Eigen::Quaterniond::Identity()) {
  BodyState state;
  state.world_from_body = {{0, 0, -10}, orientation};
  return state;
}

TEST(Craft, ANeutralBodyFloatsAndAHeavyOneFallsWithItsSubmergedWeight) {
  CraftParameters p = neutral_box();
  const EvenWater fluid;
  EXPECT_LT(
      Craft(p, BuoyantHull(testing::box(1.2, 0.8, 0.6))).acceleration_body(deep(), Vector6d::Zero(), fluid, 0).norm(),
      1e-12);
  p.mass_kg *= 2;
  const Craft heavy(p, BuoyantHull(testing::box(1.2, 0.8, 0.6)));
  EXPECT_NEAR(heavy.acceleration_body(deep(), Vector6d::Zero(), fluid, 0)(2), -fluid.gravity_m_s2 / 2, 1e-9);
}

TEST(Craft, ASphereAcceleratesWithHalfItsDisplacedMassAdded) {
  const TriangleMesh mesh = testing::sphere(0.5, 60);
  const SolidProperties solid = solid_properties(mesh);
  CraftParameters p;
  p.mass_kg = 3000 * solid.volume_m3;
  p.inertia_kg_m2 = 3000 * solid.inertia_per_density_m5;
  p.added_mass.topLeftCorner<3, 3>() = 500 * solid.volume_m3 * Eigen::Matrix3d::Identity();
  const double expected = -9.80665 * (3000.0 - 1000.0) / (3000.0 + 500.0);
  EXPECT_NEAR(Craft(p, BuoyantHull(mesh)).acceleration_body(deep(), Vector6d::Zero(), EvenWater{}, 0)(2), expected,
              1e-9);
}

TEST(Craft, ALowCentreOfMassGivesARightingMoment) {
  CraftParameters p = neutral_box();
  p.centre_of_mass_body_m = {0, 0, -0.1};
  const Craft craft(p, BuoyantHull(testing::box(1.2, 0.8, 0.6)));
  const double roll = 0.2;
  const Vector6d a = craft.acceleration_body(
      deep(Eigen::Quaterniond(Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX()))), Vector6d::Zero(), EvenWater{}, 0);
  EXPECT_NEAR(a(3), -p.mass_kg * 9.80665 * 0.1 * std::sin(roll) / p.inertia_kg_m2(0, 0), 1e-9);
}

TEST(Craft, DragDependsOnTheVelocityRelativeToTheCurrent) {
  CraftParameters p = neutral_box();
  p.linear_damping.diagonal() << 10, 20, 30, 1, 2, 3;
  p.quadratic_damping.diagonal() << 100, 200, 300, 10, 20, 30;
  const Craft craft(p, BuoyantHull(testing::box(1.2, 0.8, 0.6)));
  EvenWater fluid;
  fluid.current_world_m_s = {0.5, 0, 0};
  BodyState state = deep();
  state.velocity_body(0) = 0.5;
  EXPECT_LT(craft.acceleration_body(state, Vector6d::Zero(), fluid, 0).norm(), 1e-12) << "drifting with the water";
  state.velocity_body(0) = 1.5;
  EXPECT_NEAR(craft.acceleration_body(state, Vector6d::Zero(), fluid, 0)(0), -(10 + 100) / p.mass_kg, 1e-9);
}

TEST(Craft, InAirABodyFallsWithoutDragAndAddedMass) {
  CraftParameters p = neutral_box();
  p.added_mass.diagonal().setConstant(500);
  p.quadratic_damping.diagonal().setConstant(500);
  const Craft craft(p, BuoyantHull(testing::box(1.2, 0.8, 0.6)));
  BodyState state = deep();
  state.world_from_body.position_m.z() = 5;
  state.velocity_body(2) = -3;
  EXPECT_NEAR(craft.acceleration_body(state, Vector6d::Zero(), EvenWater{}, 0)(2), -9.80665, 1e-9);
}

TEST(Craft, AHalfSubmergedBodyHasHalfItsAddedMassAndDrag) {
  CraftParameters p = neutral_box();
  p.mass_kg *= 0.5;
  p.added_mass(0, 0) = 400;
  p.linear_damping(0, 0) = 60;
  const Craft craft(p, BuoyantHull(testing::box(1.2, 0.8, 0.6)));
  BodyState state;
  state.velocity_body(0) = 1;
  Vector6d tau = Vector6d::Zero();
  tau(0) = 100;
  EXPECT_NEAR(craft.acceleration_body(state, tau, EvenWater{}, 0)(0), (100 - 30) / (p.mass_kg + 200), 1e-9);
  EXPECT_NEAR(craft.acceleration_body(state, tau, EvenWater{}, 0)(2), 0, 1e-9) << "it floats";
}

TEST(Craft, InvalidCoefficientsAreRefused) {
  CraftParameters p = neutral_box();
  p.mass_kg = -1;
  EXPECT_THROW(p.check(), InvalidValue);
  p = neutral_box();
  p.linear_damping(1, 1) = -5;
  EXPECT_THROW(p.check(), InvalidValue);
  p = neutral_box();
  p.inertia_kg_m2.diagonal() << 1, 1, 5;
  EXPECT_THROW(p.check(), InvalidValue);
  p = neutral_box();
  p.inertia_kg_m2(0, 1) = 9;  // without its counterpart (1, 0)
  EXPECT_THROW(p.check(), InvalidValue);
  p = neutral_box();
  p.quadratic_damping.topLeftCorner<2, 2>() << 1, 0.1, 0.1, 0.01;  // semi-definite, yet v = (1, -5) gains energy
  EXPECT_THROW(p.check(), InvalidValue);
  p = neutral_box();
  p.added_mass(0, 1) = 3;
  EXPECT_THROW(p.check(), InvalidValue);
}

TEST(Craft, ACentreOfMassOutsideTheHullsBoundingBoxIsRefused) {
  CraftParameters p = neutral_box();
  p.centre_of_mass_body_m = {0, 0.4, -0.3};  // on the hull's surface
  EXPECT_NO_THROW(Craft(p, BuoyantHull(testing::box(1.2, 0.8, 0.6))));
  p.centre_of_mass_body_m.z() = -0.31;
  EXPECT_THROW(Craft(p, BuoyantHull(testing::box(1.2, 0.8, 0.6))), InvalidValue);
}

}  // namespace
}  // namespace uwsim
