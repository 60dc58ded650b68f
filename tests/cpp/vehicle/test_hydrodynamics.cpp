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

TEST(Craft, TheMunkMomentIsTheDifferenceOfTheAddedMassesTimesItsShare) {
  CraftParameters p = neutral_box();
  p.added_mass.diagonal() << 100, 300, 900, 20, 50, 40;
  BodyState state = deep();
  state.velocity_body.head<3>() << 1.0, 0.3, -0.2;
  const Eigen::Vector3d ideal((900 - 300) * 0.3 * -0.2, (100 - 900) * -0.2 * 1.0, (300 - 100) * 1.0 * 0.3);
  for (const double share : {0.0, 0.4, 1.0}) {
    p.munk_share = share;
    const Craft craft(p, BuoyantHull(testing::box(1.2, 0.8, 0.6)));
    const Vector6d a = craft.acceleration_body(state, Vector6d::Zero(), EvenWater{}, 0);
    const Eigen::Vector3d moment = (p.inertia_kg_m2 + p.added_mass.bottomRightCorner<3, 3>()) * a.tail<3>();
    EXPECT_LT((moment + share * ideal).norm(), 1e-9) << share;
    EXPECT_LT(a.head<3>().norm(), 1e-12) << "d'Alembert: no force";
  }
}

TEST(Craft, StripsKeepTheDragOfPureMotionAndCoupleTheRest) {
  CraftParameters p = neutral_box();
  p.quadratic_damping.diagonal() << 100, 200, 400, 10, 20, 30;
  const auto wrench = [&](const Vector6d& velocity) -> Vector6d {
    const Craft craft(p, BuoyantHull(testing::box(1.2, 0.8, 0.6)));
    BodyState state = deep();
    state.velocity_body = velocity;
    Vector6d mass;
    mass << Eigen::Vector3d::Constant(p.mass_kg), p.inertia_kg_m2.diagonal();
    Vector6d f = mass.cwiseProduct(craft.acceleration_body(state, Vector6d::Zero(), EvenWater{}, 0));
    f.head<3>() += p.mass_kg * Eigen::Vector3d(velocity.tail<3>()).cross(Eigen::Vector3d(velocity.head<3>()));
    return f;
  };
  for (int axis = 0; axis < 6; ++axis) {
    const Vector6d velocity = 0.7 * Vector6d::Unit(axis);
    p.crossflow_length_m = 0;
    const Vector6d whole = wrench(velocity);
    p.crossflow_length_m = 1.2;
    EXPECT_LT((wrench(velocity) - whole).norm(), 1e-9) << axis;
  }

  // Yaw: strips of 1.2 m have 200 x 1.2^3 / 32 = 10.8 of the 30 N m s^2. Pitch: 400 x 1.2^3 / 32 = 21.6 exceeds 20.
  const double yaw_m = 1.2, pitch_m = std::cbrt(32 * 20.0 / 400);
  const auto strips = [](double drag, double length, double across, double turn) {
    double force = 0, moment = 0;
    constexpr int kStrips = 20'000;
    for (int k = 0; k < kStrips; ++k) {
      const double x = length * ((k + 0.5) / kStrips - 0.5), v = across + turn * x;
      force -= drag / kStrips * v * std::abs(v);
      moment -= drag / kStrips * x * v * std::abs(v);
    }
    return Eigen::Vector2d(force, moment);
  };
  for (const double turn : {-3.0, -0.4, 0.2, 2.5}) {
    for (const double across : {-0.5, 0.0, 0.3}) {
      Vector6d velocity = Vector6d::Zero();
      velocity(1) = across;
      velocity(5) = turn;
      const Eigen::Vector2d yaw = strips(200, yaw_m, across, turn);
      EXPECT_NEAR(wrench(velocity)(1), yaw(0), 1e-5);
      EXPECT_NEAR(wrench(velocity)(5), yaw(1) - (30 - 10.8) * turn * std::abs(turn), 1e-5);
      velocity.setZero();
      velocity(2) = across;
      velocity(4) = turn;
      const Eigen::Vector2d pitch = strips(400, pitch_m, across, -turn);
      EXPECT_NEAR(wrench(velocity)(2), pitch(0), 1e-5);
      EXPECT_NEAR(wrench(velocity)(4), -pitch(1), 1e-5);
    }
  }
}

TEST(Craft, StripsOnlyDissipate) {
  const CrossflowDrag strips(400, 20, 1.2);
  for (double across = -1; across <= 1; across += 0.05) {
    for (double turn = -3; turn <= 3; turn += 0.05) {
      const CrossflowDrag::Load load = strips.load(across, turn);
      EXPECT_LE(across * load.force + turn * load.moment, 0) << across << " " << turn;
    }
  }
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
  p = neutral_box();
  p.munk_share = 1.1;
  EXPECT_THROW(p.check(), InvalidValue);
  p = neutral_box();
  p.quadratic_damping.diagonal().setConstant(10);
  p.quadratic_damping(2, 4) = 1;
  EXPECT_NO_THROW(p.check());
  p.crossflow_length_m = 1;  // a cross term has no strips
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
