#include "uwsim/dynamics/rigid_body_world.h"

#include <gtest/gtest.h>

#include "dynamics/bodies.h"
#include "uwsim/rays/ray_scene.h"

namespace uwsim {
namespace {

constexpr double kTolerance_m = 0.01;  // distance of a resting body from the surface

std::shared_ptr<const Craft> damped_box(double density_kg_m3, double drag, double added_mass = 0) {
  CraftParameters p = brick_parameters(density_kg_m3);
  p.added_mass.diagonal().setConstant(added_mass);
  p.quadratic_damping.diagonal().setConstant(drag);
  p.linear_damping.diagonal().setConstant(drag / 4);
  return craft_of(p);
}

TEST(RigidBodyWorld, AFloatingBodyDisplacesItsMass) {
  RigidBodyWorld bodies(flat_bed(-20), kStep_s);
  bodies.add_body(body_of(damped_box(400, 500, 100), 0.5), at(0, 0, -1));
  run(bodies, 20'000);
  EXPECT_NEAR(place_m(bodies).z(), 0.3 - 0.4 * 0.6, 2e-3);
}

TEST(RigidBodyWorld, ABodyRestsOnTheSurfaceThatARayMeets) {
  const World world = bed_world(41, 1, [](double x, double) { return -6 + 0.1 * x; });
  const RayScene scene(world);
  RigidBodyWorld bodies(world, kStep_s);
  bodies.add_body(body_of(damped_box(2500, 100), 0.9, 0), at(2.3, -1.7, -4));
  run(bodies, 4000);
  EXPECT_LT(bodies.state(0).velocity_body.norm(), 0.02);
  const Pose pose = bodies.state(0).world_from_body;
  const Eigen::Vector3d down = pose.direction(-Eigen::Vector3d::UnitZ());
  EXPECT_NEAR(scene.cast({pose.position_m, down}, 10).distance_m, 0.3, 2 * kTolerance_m);
}

TEST(RigidBodyWorld, AHeldBodyDoesNotCollideWithTheBed) {
  RigidBodyWorld bodies(flat_bed(-5), kStep_s);
  bodies.add_body(body_of(damped_box(3000, 100), 0.5), at(0, 0, -4.9));
  bodies.hold(0, true);
  run(bodies, 100);
  EXPECT_EQ(place_m(bodies), Eigen::Vector3d(0, 0, -4.9));
  EXPECT_FALSE(bodies.in_contact(0));
}

}  // namespace
}  // namespace uwsim
