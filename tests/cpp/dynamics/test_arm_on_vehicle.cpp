#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <vector>

#include "dynamics/arms.h"

namespace uwsim::arm_on_vehicle_tests {
namespace {

BodySpec hull_with_arm(std::vector<ArmLink> links) {
  CraftParameters p;
  p.mass_kg = 12;
  p.centre_of_mass_body_m = {0, 0, -0.02};
  p.inertia_kg_m2 = Eigen::Vector3d(0.2, 0.3, 0.4).asDiagonal();
  p.added_mass.diagonal() << 5, 8, 10, 0.1, 0.2, 0.2;
  p.linear_damping.diagonal() << 4, 6, 5, 0.1, 0.1, 0.1;
  BodySpec spec = body_of(craft_of(p, testing::box(0.4, 0.3, 0.1)), 0.5);
  spec.arm = std::move(links);
  return spec;
}

TEST(Arm, TheForcesOnItsVehicleAddUpToTheChangeOfItsVelocity) {
  EvenWater water;
  RigidBodyWorld world({}, kStep_s);
  auto links = tree(2, 5);
  for (ArmLink& link : links) link.strongest = 5;
  world.add_body(hull_with_arm(links), at(0, 0, -10));
  world.arm(0)->command(0, {JointCommand::Mode::kSpeed, 0.5});
  for (int n = 0; n < 20; ++n) {
    const BodyState before = world.state(0);
    world.step(water, n * kStep_s);
    const Vector6d change = (world.state(0).velocity_body - before.velocity_body) / kStep_s;
    const Forces forces = world.forces(0, water, (n + 1) * kStep_s);
    const Vector6d expected = world.spec(0).craft->rigid_mass() * change;
    EXPECT_LT((forces.sum() - expected).norm(), 1e-9 * (1 + expected.norm()));
    EXPECT_GT(forces.arm.norm(), 0);
  }
}

TEST(Arm, AWeldedArmAndItsVehicleMoveAsOneBody) {
  ArmLink block = rod("block", ArmLink::kBase, {0.1, 0.05, 0.02}, 3);
  block.joint = ArmLink::Joint::kFixed;
  block.centre_of_mass_m.setZero();
  RigidBodyWorld two({}, kStep_s), one({}, kStep_s);
  BodyState start;
  start.velocity_body << 0.3, -0.1, 0.2, 1.5, -2, 1;
  const BodySpec hull = hull_with_arm({block});
  two.add_body(hull, start);
  CraftParameters p = hull.craft->parameters();
  const Eigen::Vector3d of_block(0.1, 0.05, 0.02), centre = (12 * p.centre_of_mass_body_m + 3 * of_block) / 15;
  const auto parallel = [](double mass, const Eigen::Vector3d& d) -> Eigen::Matrix3d {
    return mass * (d.squaredNorm() * Eigen::Matrix3d::Identity() - d * d.transpose());
  };
  p.inertia_kg_m2 +=
      block.inertia_kg_m2 + parallel(12, p.centre_of_mass_body_m - centre) + parallel(3, of_block - centre);
  p.mass_kg = 15;
  p.centre_of_mass_body_m = centre;
  p.added_mass.setZero();
  p.linear_damping.setZero();
  BodySpec both = hull;
  both.arm.clear();
  both.craft = craft_of(p, testing::box(0.4, 0.3, 0.1));
  one.add_body(both, start);
  for (RigidBodyWorld* world : {&one, &two}) {
    BodyState high = world->state(0);
    high.world_from_body.position_m.z() = 50;
    world->set_state(0, high);
    run(*world, 400, vacuum());  // above the water
  }
  EXPECT_LT((place_m(one) - place_m(two)).norm(), 1e-9);
  EXPECT_LT((one.state(0).velocity_body - two.state(0).velocity_body).norm(), 1e-9);
}

}  // namespace
}  // namespace uwsim::arm_on_vehicle_tests
