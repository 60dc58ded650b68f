#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "dynamics/bodies.h"

// Laws of contacts of an arm's links: each is solved with the whole tree, its motors and its vehicle.
namespace uwsim::arm_contact_tests {
namespace {

constexpr double kBed_m = -10;

World bed() { return flat_bed(kBed_m, 41, 0.5); }

BodySpec body(const std::string& name, const Eigen::Vector3d& size_m, double mass_kg, std::vector<ArmLink> arm = {}) {
  BodySpec spec;
  spec.name = name;
  const TriangleMesh mesh = testing::box(size_m.x(), size_m.y(), size_m.z());
  spec.craft = craft_of(solid_of(mesh, mass_kg / size_m.prod()), mesh);
  spec.restitution = 0;
  spec.arm = std::move(arm);
  return spec;
}

/// A box from the joint along x.
ArmLink bar(const std::string& name, std::uint64_t parent, const Eigen::Vector3d& joint_m, double length_m,
            double mass_kg = 0.5) {
  const Eigen::Vector3d middle_m(length_m / 2, 0, 0);
  ArmLink link;
  link.name = name;
  link.parent = parent;
  link.parent_from_link.position_m = joint_m;
  link.axis = Eigen::Vector3d::UnitY();
  link.mass_kg = mass_kg;
  link.centre_of_mass_m = middle_m;
  const double across = mass_kg * (length_m * length_m + 0.0016) / 12;
  link.inertia_kg_m2 = Eigen::Vector3d(mass_kg * 0.0032 / 12, across, across).asDiagonal();
  link.surface_m = std::make_shared<const TriangleMesh>(testing::moved(testing::box(length_m, 0.04, 0.04), middle_m));
  return link;
}

std::vector<ArmLink> chain(std::size_t count) {
  std::vector<ArmLink> links;
  for (std::size_t k = 0; k < count; ++k) {
    const bool first = k == 0;
    links.push_back(bar("l" + std::to_string(k), first ? ArmLink::kBase : k - 1,
                        first ? Eigen::Vector3d(0.2, 0, 0) : Eigen::Vector3d(0.3, 0, 0), 0.28));
    if (k % 2 == 1) links.back().axis = Eigen::Vector3d::UnitZ();
  }
  return links;
}

/// Two fingers, 0.1 m apart at zero, on slides that close with positive positions, ahead of the hull.
std::vector<ArmLink> gripper(double strongest_n) {
  std::vector<ArmLink> fingers;
  for (const double side : {1.0, -1.0}) {
    ArmLink finger = bar(side > 0 ? "left" : "right", ArmLink::kBase, {0.5, side * 0.07, 0.3}, 0.06, 0.1);
    finger.joint = ArmLink::Joint::kSlide;
    finger.axis = {0, -side, 0};
    finger.lowest = -0.05;
    finger.highest = 0.05;
    finger.strongest = strongest_n;
    finger.fastest = 0.05;
    fingers.push_back(finger);
  }
  return fingers;
}

struct Total {
  Vector6d momentum = Vector6d::Zero();  // about the world's origin along its axes
  double energy_j = 0;
};

Total total(RigidBodyWorld& world, const WaterField& water) {
  Total sum;
  for (std::size_t k = 0; k < world.size(); ++k) {
    const BodyState& state = world.state(k);
    const Craft& craft = *world.spec(k).craft;
    Vector6d momentum = craft.rigid_mass() * state.velocity_body;
    sum.energy_j += 0.5 * state.velocity_body.dot(momentum) +
                    craft.parameters().mass_kg * water.gravity() * state.world_from_body.position_m.z();
    if (world.arm(k) != nullptr) {
      const ArticulatedBody& placed = world.arm(k)->placed(state, water, 0);
      momentum += placed.momentum_base();
      sum.energy_j += placed.kinetic_energy_j() + placed.potential_energy_j();
    }
    const Eigen::Vector3d linear = state.world_from_body.orientation * momentum.head<3>();
    sum.momentum.head<3>() += linear;
    sum.momentum.tail<3>() +=
        state.world_from_body.orientation * momentum.tail<3>() + state.world_from_body.position_m.cross(linear);
  }
  return sum;
}

TEST(ArmContact, AnImpulseAtALinkChangesTheMomentumOfTheWholeTree) {
  const EvenWater nothing = vacuum(0);
  for (const double friction : {0.0, 0.5}) {
    RigidBodyWorld world({}, 0.001);
    BodySpec rov = body("rov", {0.4, 0.3, 0.1}, 12, chain(4)), ball = body("ball", {0.1, 0.12, 0.14}, 2);
    rov.friction = ball.friction = friction;
    world.add_body(rov, at({0, 0, 5}));
    BodyState thrown = at({1.2, 0.02, 5.3});
    thrown.velocity_body << 0.1, 0.05, -1.0, 0.2, 0, 0.1;
    world.add_body(ball, thrown);
    const Total before = total(world, nothing);
    bool touched = false;
    for (int n = 0; n < 800; ++n) {
      world.step(nothing, n * 0.001);
      touched = touched || !world.touches(1).empty();
    }
    const Total after = total(world, nothing);
    EXPECT_TRUE(touched);
    EXPECT_GT(std::abs(world.arm(0)->speed(3)), 0.1);
    // The ball has 2 N s. Overlaps that are pushed apart turn what moves, at the same velocity along its own axes.
    EXPECT_LT((after.momentum - before.momentum).head<3>().norm(), 2e-3);
    EXPECT_LT((after.momentum - before.momentum).tail<3>().norm(), 0.02);  // of 10; forces act throughout a step
    EXPECT_LT(after.energy_j, before.energy_j);
  }
}

/// How far a block falls in a quarter of a second that two fingers with a given force hold.
double fall_m(double mass_kg, double force_n, bool with_torque) {
  RigidBodyWorld world(bed(), kStep_s);
  const EvenWater water = vacuum();
  world.add_body(body("rov", {0.6, 0.6, 0.4}, 1e5, gripper(force_n)), at({0, 0, kBed_m + 0.201}));
  BodySpec held = body("sample", {0.06, 0.098, 0.06}, mass_kg);
  world.add_body(held, at({0.53, 0, kBed_m + 0.501}));
  const double start_m = place_m(world, 1).z();
  for (const std::size_t finger : {0, 1})
    world.arm(0)->command(finger, with_torque ? JointCommand{JointCommand::Mode::kTorque, force_n}
                                              : JointCommand{JointCommand::Mode::kSpeed, 0.05});
  run(world, 50, water);
  return start_m - place_m(world, 1).z();
}

TEST(ArmContact, ABlockBetweenFingersSlipsWhereItsWeightExceedsFriction) {
  const double force_n = 20, most_kg = 2 * 0.5 * force_n / kGravity;
  for (const bool with_torque : {true, false}) {
    EXPECT_LT(fall_m(0.999 * most_kg, force_n, with_torque), 1e-4) << with_torque;
    const double fallen = fall_m(1.05 * most_kg, force_n, with_torque), acceleration = kGravity * (1 - 1 / 1.05);
    EXPECT_NEAR(fallen, acceleration / 2 / 16, 0.01 * acceleration / 32) << with_torque;
  }
}

TEST(ArmContact, AMotorThatClosesOnABlockGivesAllItHasAndStands) {
  RigidBodyWorld world(bed(), kStep_s);
  const EvenWater water = vacuum();
  world.add_body(body("rov", {0.6, 0.6, 0.4}, 200, gripper(15)), at({0, 0, kBed_m + 0.201}));
  run(world, 400, water);
  const Vector6d empty = world.forces(0, water, 2).arm;
  const double mass_kg = 0.5, ahead_m = 0.53;
  world.add_body(body("sample", {0.06, 0.098, 0.06}, mass_kg), at({ahead_m, 0, kBed_m + 0.501}));
  for (const std::size_t finger : {0, 1}) world.arm(0)->command(finger, {JointCommand::Mode::kPosition, 0.03});
  for (int n = 0; n < 600; ++n) world.step(water, 2 + n * kStep_s);
  for (const std::size_t finger : {0, 1}) {
    EXPECT_NEAR(world.arm(0)->motor_torque(finger), 15, 1e-6);
    EXPECT_LT(std::abs(world.arm(0)->speed(finger)), 1e-6);
  }
  double pressed_n = 0;
  for (const Touch& touch : world.touches(1)) pressed_n += std::max(0.0, touch.force_world_n.y());
  EXPECT_NEAR(pressed_n, 15, 1e-4);
  // The vehicle carries the block's weight where the block is.
  const Vector6d more = world.forces(0, water, 5).arm - empty;
  EXPECT_NEAR(more[2], -mass_kg * kGravity, 1e-3);
  EXPECT_NEAR(more[4], mass_kg * kGravity * ahead_m, 2e-3);
}

TEST(ArmContact, AFallingChainComesToRestOnTheBedAndItsEnergyNeverGrows) {
  RigidBodyWorld world(bed(), kStep_s);
  const EvenWater water = vacuum();
  auto links = chain(4);
  for (ArmLink& link : links) link.coulomb_friction = 0.02;
  BodyState start = at({0, 0, kBed_m + 0.6});
  start.world_from_body.orientation = Eigen::AngleAxisd(0.5, Eigen::Vector3d(0.3, 1, 0.2).normalized());
  world.add_body(body("rov", {0.3, 0.2, 0.1}, 3, links), start);
  double energy_j = total(world, water).energy_j, most_gained_j = 0;
  const double start_j = energy_j;
  for (int n = 0; n < 1200; ++n) {
    world.step(water, n * kStep_s);
    const double now_j = total(world, water).energy_j;
    most_gained_j = std::max(most_gained_j, now_j - energy_j);
    energy_j = now_j;
  }
  EXPECT_LT(most_gained_j, 0.002 * (start_j + 5 * kGravity * 10)) << start_j;  // of what it had to lose
  EXPECT_LT(world.state(0).velocity_body.norm(), 1e-3);
  double load_n = 0;
  for (const Touch& touch : world.touches(0)) load_n += touch.force_world_n.z();
  EXPECT_NEAR(load_n, 5 * kGravity, 0.01);
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_LT(std::abs(world.arm(0)->speed(k)), 1e-3);
    EXPECT_GT(world.arm(0)->placed(world.state(0), water, 0).world_from_link(k).position_m.z(), kBed_m);
  }
}

TEST(ArmContact, AGraspContinuesFromASavedStateToTheSameBytes) {
  const EvenWater water = vacuum();
  const auto made = [&] {
    auto world = std::make_unique<RigidBodyWorld>(bed(), kStep_s);
    world->add_body(body("rov", {0.6, 0.6, 0.4}, 50, gripper(20)), at({0, 0, kBed_m + 0.21}));
    world->add_body(body("sample", {0.06, 0.096, 0.06}, 0.8), at({0.53, 0.001, kBed_m + 0.51}));
    return world;
  };
  const auto one = made(), other = made();
  for (const std::size_t finger : {0, 1}) one->arm(0)->command(finger, {JointCommand::Mode::kPosition, 0.03});
  run(*one, 40, water);
  restore(*other, saved(*one));
  for (RigidBodyWorld* world : {one.get(), other.get()}) {
    for (int n = 40; n < 120; ++n) world->step(water, n * kStep_s);
  }
  EXPECT_EQ(saved(*one), saved(*other));
}

}  // namespace
}  // namespace uwsim::arm_contact_tests
