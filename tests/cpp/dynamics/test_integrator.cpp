#include "uwsim/dynamics/integrator.h"

#include <gtest/gtest.h>

#include <cmath>

#include "dynamics/bodies.h"
#include "uwsim/world/water.h"

namespace uwsim {
namespace {

CraftParameters neutral_box() {
  CraftParameters p = brick_parameters(1000);
  p.added_mass.diagonal() << 100, 300, 900, 20, 50, 40;
  return p;
}

Craft box_of(const CraftParameters& p) { return {p, BuoyantHull(brick())}; }

BodyState moving(double depth_m, const Vector6d& velocity_body) {
  BodyState state = at(0, 0, -depth_m);
  state.velocity_body = velocity_body;
  return state;
}

/// Deep, and turning about all axes.
BodyState tumbling() { return moving(500, Vector6d(0.5, -0.2, 0.1, 1.2, 0.9, -1.0)); }

/// The state after so many seconds in so many steps.
BodyState divided(const Craft& craft, BodyState state, double seconds, int steps) {
  for (int k = 0; k < steps; ++k) state = advance(craft, state, {}, EvenWater{}, 0, seconds / steps);
  return state;
}

BodyState run(const Craft& craft, BodyState state, const Vector6d& tau, const WaterField& water, double seconds) {
  for (int k = 0; k < std::lround(seconds / kStep_s); ++k)
    state = advance(craft, state, {.body = tau}, water, 0, kStep_s);
  return state;
}

TEST(Integrator, ATumblingBodyInInviscidWaterConservesEnergyAndMomentum) {
  const CraftParameters p = neutral_box();
  const Craft craft = box_of(p);
  const BodyState state = tumbling();
  Matrix6d mass = p.added_mass;
  mass.topLeftCorner<3, 3>() += p.mass_kg * Eigen::Matrix3d::Identity();
  mass.bottomRightCorner<3, 3>() += p.inertia_kg_m2;
  const auto momentum_world = [&](const BodyState& s) -> Eigen::Vector3d {
    return s.world_from_body.orientation * Eigen::Vector3d((mass * s.velocity_body).head<3>());
  };
  const double energy = craft.kinetic_energy_j(state);
  const Eigen::Vector3d momentum = momentum_world(state);
  const BodyState end = run(craft, state, Vector6d::Zero(), EvenWater{}, 100);
  EXPECT_NEAR(craft.kinetic_energy_j(end), energy, 1e-6 * energy);
  EXPECT_LT((momentum_world(end) - momentum).norm(), 1e-6 * momentum.norm());
  EXPECT_NEAR(end.world_from_body.orientation.norm(), 1, 1e-12);
}

/// A current in cells of a few metres, as none of the sea's are, and one of a tide.
Water in_a_field() {
  CurrentGrid grid{.x_m = {-9, -2, 1, 9}, .y_m = {-9, 0, 9}, .z_m = {-30, -10, -6, 0}, .t_s = {0, 30}, .values = {}};
  for (std::size_t k = 0; k < grid.size(); ++k) {
    const double n = static_cast<double>(k);
    grid.values.emplace_back(0.3 * std::sin(7 * n), 0.3 * std::cos(5 * n), 0.05 * std::sin(3 * n * n));
  }
  Water water;
  water.currents = {gridded_current(grid), harmonic_current({{1e-2, {0.2, 0}, {0, 0.1}}})};
  return water;
}

/// The same water, of which each stage of a step finds the flow itself.
struct ByStage : Water {
  explicit ByStage(const Water& water) : Water(water) {}
  bool flows_smoothly() const override { return false; }
};

TEST(Integrator, TheFlowOverAStepFollowsFromThatAtItsBeginning) {
  CraftParameters p = neutral_box();
  p.linear_damping.diagonal() << 40, 60, 80, 20, 20, 20;
  const Craft craft = box_of(p);
  const Water water = in_a_field();
  const ByStage by_stage(water);
  EXPECT_TRUE(water.flows_smoothly());
  const Eigen::Vector3d begin(-2.3, 0.3, -6.3);  // near edges of cells, which it crosses
  BodyState drifting = at(begin), each_stage = drifting;
  for (int k = 0; k < 4000; ++k) {
    drifting = advance(craft, drifting, {}, water, kStep_s * k, kStep_s);
    each_stage = advance(craft, each_stage, {}, by_stage, kStep_s * k, kStep_s);
  }
  const Eigen::Vector3d way = drifting.world_from_body.position_m - begin;
  EXPECT_GT(way.norm(), 1);
  EXPECT_LT((drifting.world_from_body.position_m - each_stage.world_from_body.position_m).norm(), 1e-4 * way.norm());
  EXPECT_LT((drifting.velocity_body - each_stage.velocity_body).norm(), 1e-4);
}

TEST(Integrator, AWakeThatTakesAwayMunkMomentDoesNoWork) {
  CraftParameters p = neutral_box();
  p.added_mass(0, 4) = p.added_mass(4, 0) = -30;
  p.added_mass(1, 2) = p.added_mass(2, 1) = 60;
  p.munk_share = 0.3;
  const Craft craft = box_of(p);
  const BodyState state = tumbling();
  const double energy = craft.kinetic_energy_j(state);
  const BodyState end = run(craft, state, Vector6d::Zero(), EvenWater{}, 100);
  EXPECT_NEAR(craft.kinetic_energy_j(end), energy, 1e-6 * energy);
}

TEST(Integrator, ASphereInAStraightLineDoesNotKnowItsMunkShare) {
  CraftParameters p = neutral_box();
  p.added_mass.diagonal() << 500, 500, 500, 20, 20, 20;
  const auto end_with = [&](double share) {
    p.munk_share = share;
    return run(box_of(p), tumbling(), Vector6d::Zero(), EvenWater{}, 10);
  };
  EXPECT_LT((end_with(0).world_from_body.position_m - end_with(1).world_from_body.position_m).norm(), 1e-9);
}

TEST(Integrator, AtTerminalSpeedDragEqualsThrust) {
  CraftParameters p = neutral_box();
  p.added_mass.diagonal().setConstant(300);  // equal along all axes, so that there is no Munk moment
  p.quadratic_damping.diagonal().setConstant(250);
  const BodyState start = at(0, 0, -10);
  EXPECT_NEAR(run(box_of(p), start, ahead(360), EvenWater{}, 60).velocity_body(0), std::sqrt(360.0 / 250), 1e-6);
  p.mass_kg *= 1.5;  // falls, with ten times its mass added
  p.added_mass.diagonal() << 8600, 8600, 8600, 700, 1000, 1000;
  p.quadratic_damping.diagonal().setConstant(500);
  const double speed_m_s = std::sqrt((p.mass_kg - 576) * kGravity / 500);
  EXPECT_NEAR(run(box_of(p), start, Vector6d::Zero(), EvenWater{}, 200).velocity_body(2), -speed_m_s, 1e-3);
}

TEST(Integrator, TheErrorFallsWithTheFourthPowerOfTheStep) {
  CraftParameters p = neutral_box();
  p.quadratic_damping.diagonal().setConstant(100);
  const Craft craft = box_of(p);
  const BodyState start = moving(50, Vector6d(1, 0.3, -0.2, 0.8, -0.5, 0.4));
  const auto end_with = [&](int steps) { return divided(craft, start, 4, steps).world_from_body.position_m; };
  const Eigen::Vector3d exact = end_with(6400);
  const double coarse = (end_with(100) - exact).norm(), fine = (end_with(200) - exact).norm();
  EXPECT_GT(std::log2(coarse / fine), 3.5);
}

TEST(Integrator, AChaoticTumbleConvergesOverFiveSeconds) {
  const Craft craft = box_of(neutral_box());
  const BodyState start = moving(500, Vector6d(0.8, -0.6, 0.5, 1.2, 0.9, -1.0));
  const auto end_with = [&](int steps) { return divided(craft, start, 5, steps).world_from_body.orientation; };
  const Eigen::Quaterniond exact = end_with(16'000);
  const double at_default = end_with(1000).angularDistance(exact), at_half = end_with(2000).angularDistance(exact);
  EXPECT_LT(at_default, 1e-3);
  EXPECT_LT(at_half, at_default / 8);
}

}  // namespace
}  // namespace uwsim
