#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "dynamics/arms.h"
#include "uwsim/core/check.h"
#include "uwsim/dynamics/spatial.h"

namespace uwsim::arm_tests {
namespace {

/// A base without weight and water.
class Drifting final : public ArmBase {
 public:
  explicit Drifting(const Matrix6d& mass) : mass_(mass) {}
  Load at(const BodyState& state, double) const override {
    return {mass_, -cross_force(state.velocity_body, mass_ * state.velocity_body)};
  }

 private:
  Matrix6d mass_;
};

void step(Arm& arm, const ArmBase& base, BodyState& state, const WaterField& water, double step_s, int count = 1) {
  for (int k = 0; k < count; ++k) {
    arm.begin();
    state = arm.advance(base, state, water, k * step_s, step_s);
    arm.accept();
  }
}

/// On a base that is held, under gravity alone.
void step_held(Arm& arm, int count) {
  BodyState base;
  step(arm, HeldBase(), base, vacuum(), kStep_s, count);
}

/// An arm on a base that drifts in empty space.
struct Adrift {
  Adrift(const std::vector<ArmLink>& links, double step_s) : arm(links, step_s), step_s(step_s) {}
  void step(int count = 1) { arm_tests::step(arm, Drifting(mass), state, vacuum(0), step_s, count); }
  Vector6d momentum() {
    const Vector6d base = arm.placed(state, vacuum(0), 0).momentum_base() + mass * state.velocity_body;
    const Pose& pose = state.world_from_body;
    Vector6d world;
    const Eigen::Vector3d linear = pose.direction(base.head<3>());
    world << linear, pose.direction(base.tail<3>()) + pose.position_m.cross(linear);
    return world;
  }
  double energy_j() {
    return arm.placed(state, vacuum(0), 0).kinetic_energy_j() +
           0.5 * state.velocity_body.dot(mass * state.velocity_body);
  }

  const Matrix6d mass = Vector6d(5, 5, 5, 0.3, 0.2, 0.4).asDiagonal();
  Arm arm;
  double step_s;
  BodyState state;
};

/// Accelerations of a compound double pendulum, angles from the horizontal, downward positive (Lagrange).
std::array<double, 2> pendulum(const std::array<double, 4>& s) {
  constexpr double m = 1, c = 0.2, l = 0.4, inertia = 0.015;
  const double a = s[0], b = s[0] + s[1], wa = s[2], wb = s[2] + s[3];
  const double m11 = inertia + m * c * c + m * l * l, m12 = m * l * c * std::cos(a - b), m22 = inertia + m * c * c;
  const double f1 = (m * c + m * l) * kGravity * std::cos(a) - m * l * c * std::sin(a - b) * wb * wb;
  const double f2 = m * c * kGravity * std::cos(b) + m * l * c * std::sin(a - b) * wa * wa;
  const double det = m11 * m22 - m12 * m12;
  const double aa = (m22 * f1 - m12 * f2) / det, ab = (m11 * f2 - m12 * f1) / det;
  return {aa, ab - aa};
}

std::array<double, 4> integrated(std::array<double, 4> s, double step_s, int count) {
  const auto rate = [](const std::array<double, 4>& at) {
    const auto [a, b] = pendulum(at);
    return std::array<double, 4>{at[2], at[3], a, b};
  };
  const auto ahead = [](std::array<double, 4> from, const std::array<double, 4>& by, double h) {
    for (std::size_t k = 0; k < 4; ++k) from[k] += h * by[k];
    return from;
  };
  for (int n = 0; n < count; ++n) {
    const auto k1 = rate(s), k2 = rate(ahead(s, k1, step_s / 2)), k3 = rate(ahead(s, k2, step_s / 2)),
               k4 = rate(ahead(s, k3, step_s));
    for (std::size_t k = 0; k < 4; ++k) s[k] += step_s / 6 * (k1[k] + 2 * k2[k] + 2 * k3[k] + k4[k]);
  }
  return s;
}

TEST(ArticulatedBody, ADoublePendulumMovesAsLagrangesEquationsSay) {
  Arm arm({rod("upper", ArmLink::kBase, {0, 0, 0}), rod("lower", 0, {0.4, 0, 0})}, 1e-3);
  arm.place(0, 0.3, 0);
  arm.place(1, 0.5, 1);
  BodyState base;
  step(arm, HeldBase(), base, vacuum(), 1e-3, 2000);
  const std::array<double, 4> exact = integrated({0.3, 0.5, 0, 1}, 1e-4, 20000);
  EXPECT_NEAR(arm.position(0), exact[0], 1e-8);
  EXPECT_NEAR(arm.position(1), exact[1], 1e-8);
  EXPECT_NEAR(arm.speed(0), exact[2], 1e-7);
}

TEST(ArticulatedBody, AFloatingTreeKeepsMomentumAndEnergy) {
  for (const int seed : {1, 2, 3}) {
    Adrift it(tree(seed, 7), 1e-3);
    it.state.velocity_body << 0.1, -0.2, 0.3, 0.4, -0.1, 0.2;
    for (std::size_t k = 0; k < it.arm.size(); ++k) it.arm.place(k, 0.1, k % 2 == 0 ? 0.5 : -0.7);
    const Vector6d before = it.momentum();
    const double joules = it.energy_j();
    it.step(1000);
    EXPECT_LT((it.momentum() - before).norm(), 1e-8 * before.norm()) << seed;
    EXPECT_NEAR(it.energy_j(), joules, 1e-8 * joules) << seed;
  }
}

TEST(ArticulatedBody, TheReactionOnTheBaseIsTheRateOfMomentumLessTheWeight) {
  Arm arm(tree(5, 6), kStep_s);
  BodyState base;
  for (std::size_t k = 0; k < arm.size(); ++k) arm.place(k, 0.2, 0.3);
  const double h = 1e-5;
  const Vector6d before = arm.placed(base, vacuum(), 0).momentum_base();
  step(arm, HeldBase(), base, vacuum(), h);
  const Vector6d rate = (arm.placed(base, vacuum(), 0).momentum_base() - before) / h;
  Vector6d weight = Vector6d::Zero();
  for (std::size_t k = 0; k < arm.size(); ++k) {
    const Eigen::Vector3d force(0, 0, -kGravity * arm.links()[k].mass_kg);
    const Eigen::Vector3d at = arm.placed(base, vacuum(), 0).world_from_link(k).point(arm.links()[k].centre_of_mass_m);
    weight.head<3>() += force;
    weight.tail<3>() += at.cross(force);
  }
  EXPECT_LT((arm.stage_wrenches()[0] + rate - weight).norm(), 1e-3 * weight.norm());
}

TEST(ArticulatedBody, AWeldedLinkMovesAsPartOfItsBase) {
  // A body of two blocks, in the water, against a craft that is both: the added mass of each has its own Coriolis
  // force.
  ArmLink block = rod("block", ArmLink::kBase, {0.5, 0.1, -0.2}, 3);
  block.joint = ArmLink::Joint::kFixed;
  block.volume_m3 = 0.003;
  block.added_mass = Vector6d(2, 4, 6, 0.1, 0.2, 0.3).asDiagonal();
  block.parent_from_link.orientation = Eigen::Quaterniond(0.9, 0.1, -0.3, 0.2).normalized();
  ArticulatedBody welded({block});
  block.joint = ArmLink::Joint::kHinge;
  ArticulatedBody hinged({block});
  EvenWater water;
  water.current_world_m_s = {0.3, -0.2, 0.1};
  BodyState base = at(0, 0, -10);
  base.velocity_body << 1, 0.5, -0.3, 0.4, -0.6, 0.2;
  const std::vector<double> zero = {0};
  welded.place(base, zero, zero, water, 0);
  hinged.place(base, zero, zero, water, 0);
  const std::vector<JointDrive> still = {{true, 0}};
  const auto one = welded.fold(still), other = hinged.fold(still);
  EXPECT_TRUE(one.inertia.isApprox(other.inertia, 1e-14));
  EXPECT_TRUE(one.bias.isApprox(other.bias, 1e-14));
  // Kirchhoff: with all of it moved to the base's origin, the added mass's force is that of one matrix there.
  const SpatialTransform from_block{block.parent_from_link.rotation(), block.parent_from_link.position_m};
  const Matrix6d added = from_block.inertia_to_parent(block.added_mass);
  Vector6d current = Vector6d::Zero();
  current.head<3>() = water.current_world_m_s;
  const Vector6d relative = base.velocity_body - current;
  Vector6d current_rate = Vector6d::Zero();
  current_rate.head<3>() = -base.angular_body_rad_s().cross(water.current_world_m_s);
  block.added_mass.setZero();
  ArticulatedBody dry({block});
  dry.place(base, zero, zero, water, 0);
  const Vector6d of_added = cross_force(relative, added * relative) - added * current_rate;
  EXPECT_TRUE((one.bias - dry.fold(still).bias).isApprox(of_added, 1e-12));
}

TEST(ArticulatedBody, ANeutralLinkDriftsWithTheCurrentWithoutLoad) {
  ArmLink ball = rod("ball", ArmLink::kBase, {0.3, 0, 0}, 2);
  ball.centre_of_mass_m.setZero();
  ball.volume_m3 = 0.002;
  ball.added_mass.diagonal() << 1, 1, 1, 0, 0, 0;
  ball.quadratic_drag.fill(5);
  EvenWater water;
  water.current_world_m_s = {0.4, 0.1, 0};
  BodyState base = at(0, 0, -5);
  base.velocity_body.head<3>() = water.current_world_m_s;
  ArticulatedBody body({ball});
  const std::vector<double> zero = {0};
  body.place(base, zero, zero, water, 0);
  const std::vector<JointDrive> loose = {{false, 0}};
  EXPECT_LT(body.fold(loose).bias.norm(), 1e-12);
}

/// The same water, of which the arm does not know that it is the same everywhere.
class UnknownWater final : public EvenWater {
 public:
  explicit UnknownWater(const EvenWater& water) : EvenWater(water) {}
  bool flows_evenly() const override { return false; }
};

std::vector<ArmLink> wet_tree(int seed) {
  std::mt19937 draw(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::vector<ArmLink> links = tree(seed, 7);
  for (std::size_t k = 0; k < links.size(); ++k) {
    ArmLink& link = links[k];
    if (k % 3 == 0) link.joint = ArmLink::Joint::kFixed;
    link.volume_m3 = 0.002;
    link.centre_of_buoyancy_m = {unit(draw), unit(draw), unit(draw)};
    if (k % 2 == 0) link.added_mass.topLeftCorner<3, 3>() = 0.7 * Eigen::Matrix3d::Identity();
    link.linear_drag = Vector6d::Constant(0.3);
    link.quadratic_drag = Vector6d(1, 2, 3, 0.1, 0.2, 0);
  }
  return links;
}

TEST(ArticulatedBody, DeepInEvenWaterItHasTheLoadsOfItsLinksOneByOne) {
  std::mt19937 draw(2);
  std::uniform_real_distribution<double> unit(-1, 1);
  EvenWater water;
  water.current_world_m_s = {0.4, -0.3, 0.1};
  for (int seed = 0; seed < 20; ++seed) {
    ArticulatedBody known(wet_tree(seed)), one_by_one(wet_tree(seed));
    BodyState base;
    base.world_from_body = {{1, 2, -50}, Eigen::Quaterniond(1, unit(draw), unit(draw), unit(draw)).normalized()};
    for (double& value : base.velocity_body) value = unit(draw);
    std::vector<double> positions(7), speeds(7);
    for (double& value : positions) value = unit(draw);
    for (double& value : speeds) value = unit(draw);
    known.place(base, positions, speeds, water, 0);
    one_by_one.place(base, positions, speeds, UnknownWater(water), 0);
    const std::vector<JointDrive> drives(7);
    const auto &a = known.fold(drives), &b = one_by_one.fold(drives);
    EXPECT_LT((a.inertia - b.inertia).norm(), 1e-12 * b.inertia.norm()) << seed;
    EXPECT_LT((a.bias - b.bias).norm(), 1e-12 * (1 + b.bias.norm())) << seed;
    EXPECT_NEAR(known.potential_energy_j(), one_by_one.potential_energy_j(), 1e-9) << seed;
    // Where a link may reach the surface, the two are one.
    base.world_from_body.position_m.z() = -1;
    known.place(base, positions, speeds, water, 0);
    one_by_one.place(base, positions, speeds, UnknownWater(water), 0);
    EXPECT_EQ(known.fold(drives).bias, one_by_one.fold(drives).bias) << seed;
  }
}

TEST(Arm, NoLinkLeavesItsBounds) {
  for (int seed = 0; seed < 20; ++seed) {
    Arm arm(tree(seed, 7), kStep_s);
    BodyState base, next;
    std::mt19937 draw(seed);
    std::uniform_real_distribution<double> unit(-3, 3);
    for (std::size_t k = 0; k < arm.size(); ++k) arm.place(k, unit(draw), unit(draw));
    for (double& value : base.velocity_body) value = unit(draw);
    arm.begin();
    next = arm.advance(HeldBase(), base, vacuum(), 0, kStep_s);
    const Arm::Bounds bounds = arm.bounds(base, next);
    std::vector<Arm::LinkMotion> motions(arm.size());
    arm.find_motions(base, next, motions);
    for (const Arm::LinkMotion& motion : motions) {
      EXPECT_LE(motion.world_from_link.position_m.norm(), bounds.extent_m) << seed;
      EXPECT_LE(motion.linear_m_s, bounds.fastest_m_s) << seed;
    }
  }
}

TEST(Arm, FrictionHoldsAJointUpToItsTorque) {
  const double torque = kGravity * 0.2;  // of the link's weight, level
  for (const double share : {1.01, 0.99}) {
    ArmLink link = rod("l", ArmLink::kBase, {0, 0, 0});
    link.coulomb_friction = share * torque;
    Arm arm({link}, kStep_s);
    step_held(arm, 200);
    EXPECT_EQ(arm.position(0) == 0, share > 1) << share;
  }
}

TEST(Arm, CoulombFrictionStopsASpinningRotorInItsTime) {
  ArmLink link = rod("l", ArmLink::kBase, {0, 0, 0});
  link.centre_of_mass_m.setZero();
  link.gear_ratio = 100;
  link.rotor_inertia_kg_m2 = 1e-6;  // 0.01 at the joint
  link.coulomb_friction = 0.05;
  Arm arm({link}, kStep_s);
  arm.place(0, 0, 1);
  step_held(arm, 95);  // inertia 0.025, so it turns for 0.5 s and 0.25 rad
  EXPECT_GT(arm.speed(0), 0);
  step_held(arm, 10);
  EXPECT_EQ(arm.speed(0), 0);
  EXPECT_NEAR(arm.position(0), 0.25, 1e-9);
}

TEST(Arm, AStopTakesTheSpeedAndNothingPassesIt) {
  std::vector<ArmLink> links = tree(4, 5);
  for (ArmLink& link : links) link.lowest = -0.2, link.highest = 0.3;
  Adrift it(links, kStep_s);
  for (std::size_t k = 0; k < it.arm.size(); ++k) it.arm.place(k, 0, k % 2 == 0 ? 2 : -3);
  const Vector6d before = it.momentum();
  const double first = it.energy_j();
  double last = first;
  for (int n = 0; n < 400; ++n) {
    it.step();
    const double now = it.energy_j();
    EXPECT_LT(now, last + 1e-3 * first);
    last = now;
    for (std::size_t k = 0; k < it.arm.size(); ++k) {
      EXPECT_GE(it.arm.position(k), -0.2);
      EXPECT_LE(it.arm.position(k), 0.3);
    }
  }
  EXPECT_LT(last, 0.9 * first);
  EXPECT_LT((it.momentum() - before).norm(), 0.01 * before.norm());
}

TEST(Arm, AMotorHoldsItsSpeedUntilItsTorqueIsSpent) {
  ArmLink link = rod("l", ArmLink::kBase, {0, 0, 0});
  link.strongest = 1.0;  // half of what holds the link level
  link.fastest = 0.5;
  Arm arm({link}, kStep_s);
  arm.place(0, std::numbers::pi / 2, 0);  // hanging down
  arm.command(0, {JointCommand::Mode::kSpeed, -0.5});
  step_held(arm, 20);
  EXPECT_DOUBLE_EQ(arm.speed(0), -0.5);
  step_held(arm, 2000);
  EXPECT_DOUBLE_EQ(std::abs(arm.motor_torque(0)), 1.0);
  EXPECT_GT(arm.position(0), 0.9);  // it cannot lift it to the level
  arm.command(0, {JointCommand::Mode::kPosition, std::numbers::pi / 2});
  step_held(arm, 2000);
  EXPECT_NEAR(arm.position(0), std::numbers::pi / 2, 1e-6);
}

TEST(Arm, BadLinksAreRefused) {
  const auto refused = [](auto change) {
    std::vector<ArmLink> links = {rod("a", ArmLink::kBase, {0, 0, 0}), rod("b", 0, {1, 0, 0})};
    change(links);
    EXPECT_THROW(Arm(links, kStep_s), InvalidValue);
  };
  refused([](auto& l) { l[1].mass_kg = 0; });
  refused([](auto& l) { l[0].parent = 1; });
  refused([](auto& l) { l[1].name = "a"; });
  refused([](auto& l) { l[1].lowest = 1, l[1].highest = -1; });
  refused([](auto& l) { l[1].axis.setZero(); });
  refused([](auto& l) { l[1].viscous_friction = 1e6; });
  refused([](auto& l) { l[1].added_mass(0, 0) = -1; });
}

}  // namespace
}  // namespace uwsim::arm_tests
