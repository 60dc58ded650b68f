#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <vector>

#include "meshes.h"
#include "uwsim/dynamics/rigid_body_world.h"

namespace uwsim::arm_on_vehicle_tests {
namespace {

constexpr double kGravity = 9.80665, kStep_s = 0.005;

EvenWater air(double gravity = kGravity) {
  EvenWater water;
  water.density_kg_m3 = 1e-12;
  water.gravity_m_s2 = gravity;
  return water;
}

ArmLink rod(const std::string& name, std::uint64_t parent, const Eigen::Vector3d& at_m, double mass_kg = 1) {
  ArmLink link;
  link.name = name;
  link.parent = parent;
  link.parent_from_link.position_m = at_m;
  link.axis = Eigen::Vector3d::UnitY();
  link.mass_kg = mass_kg;
  link.centre_of_mass_m = {0.2, 0, 0};
  link.inertia_kg_m2 = Eigen::Vector3d(0.001, 0.015, 0.015).asDiagonal();
  return link;
}

std::vector<ArmLink> tree(int seed, std::size_t links) {
  std::mt19937 draw(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::vector<ArmLink> all;
  for (std::size_t k = 0; k < links; ++k) {
    const std::uint64_t parent = k == 0 ? ArmLink::kBase : draw() % k;
    ArmLink link = rod("l" + std::to_string(k), parent, {unit(draw), unit(draw), unit(draw)});
    link.joint = k % 3 == 2 ? ArmLink::Joint::kSlide : ArmLink::Joint::kHinge;
    link.axis = {unit(draw), unit(draw), 1};
    link.parent_from_link.orientation = Eigen::Quaterniond(1, unit(draw), unit(draw), unit(draw)).normalized();
    all.push_back(link);
  }
  return all;
}

BodySpec hull_with_arm(std::vector<ArmLink> links) {
  CraftParameters p;
  p.mass_kg = 12;
  p.centre_of_mass_body_m = {0, 0, -0.02};
  p.inertia_kg_m2 = Eigen::Vector3d(0.2, 0.3, 0.4).asDiagonal();
  p.added_mass.diagonal() << 5, 8, 10, 0.1, 0.2, 0.2;
  p.linear_damping.diagonal() << 4, 6, 5, 0.1, 0.1, 0.1;
  return {"rov",
          std::make_shared<const Craft>(p, BuoyantHull(testing::box(0.4, 0.3, 0.1))),
          CollisionShape::kHull,
          0.5,
          0.1,
          {},
          std::move(links)};
}

TEST(Arm, TheForcesOnItsVehicleAddUpToTheChangeOfItsVelocity) {
  EvenWater water;
  RigidBodyWorld world({}, kStep_s);
  auto links = tree(2, 5);
  for (ArmLink& link : links) link.strongest = 5;
  BodyState start;
  start.world_from_body.position_m.z() = -10;
  world.add_body(hull_with_arm(links), start);
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
  const Eigen::Vector3d at(0.1, 0.05, 0.02), centre = (12 * p.centre_of_mass_body_m + 3 * at) / 15;
  const auto parallel = [](double mass, const Eigen::Vector3d& d) -> Eigen::Matrix3d {
    return mass * (d.squaredNorm() * Eigen::Matrix3d::Identity() - d * d.transpose());
  };
  p.inertia_kg_m2 += block.inertia_kg_m2 + parallel(12, p.centre_of_mass_body_m - centre) + parallel(3, at - centre);
  p.mass_kg = 15;
  p.centre_of_mass_body_m = centre;
  p.added_mass.setZero();
  p.linear_damping.setZero();
  BodySpec both = hull;
  both.arm.clear();
  both.craft = std::make_shared<const Craft>(p, BuoyantHull(testing::box(0.4, 0.3, 0.1)));
  one.add_body(both, start);
  const EvenWater nothing = air();  // above it
  for (RigidBodyWorld* world : {&one, &two}) {
    BodyState high = world->state(0);
    high.world_from_body.position_m.z() = 50;
    world->set_state(0, high);
    for (int n = 0; n < 400; ++n) world->step(nothing, n * kStep_s);
  }
  EXPECT_LT((one.state(0).world_from_body.position_m - two.state(0).world_from_body.position_m).norm(), 1e-9);
  EXPECT_LT((one.state(0).velocity_body - two.state(0).velocity_body).norm(), 1e-9);
}

TEST(Arm, ASavedStateContinuesToTheSameBytes) {
  EvenWater water;
  const auto made = [] {
    auto world = std::make_unique<RigidBodyWorld>(World{}, kStep_s);
    auto links = tree(2, 5);
    for (ArmLink& link : links) link.strongest = 5, link.coulomb_friction = 0.1, link.highest = 0.4;
    BodyState start;
    start.world_from_body.position_m.z() = -10;
    world->add_body(hull_with_arm(links), start);
    return world;
  };
  const auto bytes = [](RigidBodyWorld& world) {
    StateArchive archive;
    world.exchange_state(archive);
    world.exchange_last_step(archive);
    world.exchange_arms(archive);
    return archive.bytes();
  };
  const auto one = made(), other = made();
  one->arm(0)->command(1, {JointCommand::Mode::kSpeed, 0.7});
  for (int n = 0; n < 50; ++n) one->step(water, n * kStep_s);
  const std::string saved = bytes(*one);
  StateArchive archive(saved);
  other->exchange_state(archive);
  other->exchange_last_step(archive);
  other->exchange_arms(archive);
  for (int n = 50; n < 100; ++n) {
    one->step(water, n * kStep_s);
    other->step(water, n * kStep_s);
  }
  EXPECT_EQ(bytes(*one), bytes(*other));
}

}  // namespace
}  // namespace uwsim::arm_on_vehicle_tests
