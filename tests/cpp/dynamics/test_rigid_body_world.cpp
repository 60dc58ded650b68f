#include "uwsim/dynamics/rigid_body_world.h"

#include <gtest/gtest.h>

#include <cmath>

#include "dynamics/bodies.h"
#include "meshes.h"
#include "uwsim/core/check.h"
#include "uwsim/rays/ray_scene.h"

namespace uwsim {
namespace {

constexpr double kTolerance_m = 0.01;  // distance of a resting body from the surface

std::shared_ptr<const Craft> box_craft(double density_kg_m3, double added_mass = 0, double drag = 100) {
  const TriangleMesh mesh = testing::box(1.2, 0.8, 0.6);
  const SolidProperties solid = solid_properties(mesh);
  CraftParameters p;
  p.mass_kg = density_kg_m3 * solid.volume_m3;
  p.inertia_kg_m2 = density_kg_m3 * solid.inertia_per_density_m5;
  p.added_mass.diagonal().setConstant(added_mass);
  p.quadratic_damping.diagonal().setConstant(drag);
  p.linear_damping.diagonal().setConstant(drag / 4);
  return std::make_shared<const Craft>(p, BuoyantHull(mesh));
}

World flat_world(float z_m, double slope = 0) {
  std::vector<float> heights;
  for (int j = 0; j < 41; ++j) {
    for (int i = 0; i < 41; ++i) heights.push_back(z_m + static_cast<float>(slope * (i - 20)));
  }
  World world;
  world.set_terrain(Heightfield(heights, 41, 41, 1.0, {-20, -20}));
  return world;
}

TEST(RigidBodyWorld, AFloatingBodyDisplacesItsMass) {
  RigidBodyWorld bodies(flat_world(-20), kStep_s);
  bodies.add_body({"raft", box_craft(400, 100, 500), CollisionShape::kHull, 0.5, 0.1}, at(0, 0, -1));
  for (int k = 0; k < 20'000; ++k) bodies.step(EvenWater{}, 0);
  EXPECT_NEAR(bodies.state(0).world_from_body.position_m.z(), 0.3 - 0.4 * 0.6, 2e-3);
}

TEST(RigidBodyWorld, AHeavyBodyComesToRestOnTheBed) {
  for (const double added : {0.0, 5000.0}) {
    RigidBodyWorld bodies(flat_world(-5), kStep_s);
    bodies.add_body({"anchor", box_craft(2500, added), CollisionShape::kHull, 0.5, 0.1}, at(0.3, 0.2, -3));
    for (int k = 0; k < 4000; ++k) bodies.step(EvenWater{}, 0);
    EXPECT_TRUE(bodies.in_contact(0));
    EXPECT_NEAR(bodies.state(0).world_from_body.position_m.z(), -5 + 0.3, kTolerance_m);
    EXPECT_LT(bodies.state(0).velocity_body.norm(), 0.02);
  }
}

TEST(RigidBodyWorld, FrictionHoldsABodyOnASlopeBelowTheFrictionAngle) {
  const double slope = 0.3;
  const auto slid = [&](double friction) {
    RigidBodyWorld bodies(flat_world(-10, slope), kStep_s);
    BodyState state = at(0, 0, -10 + 0.35);
    state.world_from_body.orientation = Eigen::AngleAxisd(-std::atan(slope), Eigen::Vector3d::UnitY());
    bodies.add_body({"block", box_craft(3000, 0, 0), CollisionShape::kHull, friction, 0}, state);
    for (int k = 0; k < 1000; ++k) bodies.step(EvenWater{}, 0);
    return std::abs(bodies.state(0).world_from_body.position_m.x());
  };
  EXPECT_LT(slid(0.6), 0.05);
  EXPECT_GT(slid(0.05), 1.0);
}

TEST(RigidBodyWorld, EnergyNeverGrowsWhenABodyHitsAWallAtAnAngle) {
  World world;
  TriangleMesh wall = testing::box(0.4, 40, 40);
  const Eigen::Matrix3d rotation = Eigen::AngleAxisd(0.785, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  for (auto& v : wall.vertices_m) v = rotation * v + Eigen::Vector3d(3, 0, -30);
  world.add_solid("wall", wall);
  RigidBodyWorld bodies(world, kStep_s);
  const auto craft = [] {
    const TriangleMesh mesh = testing::box(1.2, 0.8, 0.6);
    const SolidProperties solid = solid_properties(mesh);
    CraftParameters p;
    p.mass_kg = 1000 * solid.volume_m3;
    p.inertia_kg_m2 = 1000 * solid.inertia_per_density_m5;
    p.added_mass.diagonal() << 200, 3000, 5000, 100, 100, 400;
    return std::make_shared<const Craft>(p, BuoyantHull(mesh));
  }();
  BodyState state = at(0, 0, -30);
  state.velocity_body(0) = 2;
  bodies.add_body({"rov", craft, CollisionShape::kHull, 0, 0}, state);
  double energy = craft->kinetic_energy_j(state);
  bool touched = false;
  for (int k = 0; k < 1000; ++k) {
    bodies.step(EvenWater{}, 0);
    touched |= bodies.in_contact(0);
    const double now = craft->kinetic_energy_j(bodies.state(0));
    ASSERT_LT(now, energy * (1 + 1e-3)) << "step " << k;
    energy = now;
  }
  EXPECT_TRUE(touched);
}

TEST(RigidBodyWorld, ABodyRestsOnTheSurfaceThatARayMeets) {
  const World world = flat_world(-6, 0.1);
  const RayScene scene(world);
  RigidBodyWorld bodies(world, kStep_s);
  bodies.add_body({"anchor", box_craft(2500), CollisionShape::kHull, 0.9, 0}, at(2.3, -1.7, -4));
  for (int k = 0; k < 4000; ++k) bodies.step(EvenWater{}, 0);
  const Pose pose = bodies.state(0).world_from_body;
  const Eigen::Vector3d down = pose.direction(-Eigen::Vector3d::UnitZ());
  EXPECT_NEAR(scene.cast({pose.position_m, down}, 10).distance_m, 0.3, 2 * kTolerance_m);
}

TEST(RigidBodyWorld, AFastBodyDoesNotPassThroughAGateBar) {
  World world;
  TriangleMesh bar = testing::box(0.2, 6, 0.2);
  for (auto& v : bar.vertices_m) v += Eigen::Vector3d(5, 0, -10);
  world.add_solid("bar", bar);
  RigidBodyWorld bodies(world, kStep_s);
  BodyState state = at(0, 0, -10);
  state.velocity_body(0) = 4;
  bodies.add_body({"rov", box_craft(1000, 0, 0), CollisionShape::kHull, 0.5, 0}, state);
  for (int k = 0; k < 1000; ++k) bodies.step(EvenWater{}, 0);
  EXPECT_LT(bodies.state(0).world_from_body.position_m.x(), 5);
}

TEST(RigidBodyWorld, TwoCollidingBodiesConserveMomentumAndSeparate) {
  RigidBodyWorld bodies(flat_world(-50), kStep_s);
  const auto craft = box_craft(1000, 0, 0);
  BodyState left = at(-2, 0, -20), right = at(2, 0.1, -20);
  left.velocity_body(0) = 1;
  right.velocity_body(0) = -0.5;
  bodies.add_body({"left", craft, CollisionShape::kHull, 0.5, 0.3}, left);
  bodies.add_body({"right", craft, CollisionShape::kHull, 0.5, 0.3}, right);
  bool touched = false;
  for (int k = 0; k < 2000; ++k) {
    bodies.step(EvenWater{}, 0);
    touched |= bodies.in_contact(0) && bodies.in_contact(1);
  }
  EXPECT_TRUE(touched);
  const auto velocity = [&](std::size_t k) -> Eigen::Vector3d {
    return bodies.state(k).world_from_body.direction(bodies.state(k).linear_body_m_s());
  };
  // Separating an overlap rotates the bodies slightly, and their velocities with them.
  EXPECT_LT((velocity(0) + velocity(1) - Eigen::Vector3d(0.5, 0, 0)).norm(), 2e-3);
  EXPECT_LT(velocity(0).x(), velocity(1).x());
}

TEST(RigidBodyWorld, AHeldBodyNeitherMovesNorCollides) {
  RigidBodyWorld bodies(flat_world(-5), kStep_s);
  bodies.add_body({"rov", box_craft(3000), CollisionShape::kHull, 0.5, 0.1}, at(0, 0, -4.9));
  bodies.hold(0, true);
  for (int k = 0; k < 100; ++k) bodies.step(EvenWater{}, 0);
  EXPECT_EQ(bodies.state(0).world_from_body.position_m, Eigen::Vector3d(0, 0, -4.9));
  EXPECT_FALSE(bodies.in_contact(0));
}

}  // namespace
}  // namespace uwsim
