#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "dynamics/bodies.h"
#include "uwsim/world/water.h"

// Stacked bodies at rest: friction holds them in place, to the last bit, until something changes.
namespace uwsim {
namespace {

constexpr double kFriction = 0.6, kHeight_m = 0.6, kBed_m = -10;
constexpr std::size_t kMinute = 12'000;  // steps

std::shared_ptr<const Craft> block(double density_kg_m3 = 2000) {
  CraftParameters p = brick_parameters(density_kg_m3);
  p.added_mass.diagonal() << 300, 500, 900, 30, 50, 40;
  p.linear_damping.diagonal() << 50, 50, 50, 20, 20, 20;
  return craft_of(p);
}

double weight_in_water_n() { return 1000 * 1.2 * 0.8 * kHeight_m * kGravity; }

/// A stack of slightly misaligned blocks, each dropped from a centimetre above the one below.
class Stack {
 public:
  explicit Stack(std::size_t count) : bodies_(flat_bed(kBed_m), kStep_s) {
    for (std::size_t k = 0; k < count; ++k) {
      const double number = static_cast<double>(k);
      BodyState state = at(0.05 * std::sin(7 * number), 0.03 * std::cos(5 * number),
                           kBed_m + 0.01 + kHeight_m / 2 + (kHeight_m + 0.01) * number);
      state.world_from_body.orientation = Eigen::AngleAxisd(0.1 * std::sin(3 * number), Eigen::Vector3d::UnitZ());
      add(state);
    }
    step(1000);
  }

  void add(const BodyState& state) { bodies_.add_body(body_of(block(), kFriction), state); }
  void step(std::size_t count) { run(bodies_, static_cast<int>(count)); }
  void pull(std::size_t body, double force_n) { bodies_.set_wrench(body, ahead(force_n)); }
  Eigen::Vector3d place_m(std::size_t body) const { return uwsim::place_m(bodies_, body); }
  RigidBodyWorld& bodies() { return bodies_; }
  /// Continues in a new world, which remembers nothing of the preceding steps.
  void forget(std::size_t count) {
    RigidBodyWorld fresh(flat_bed(kBed_m), kStep_s);
    std::swap(fresh, bodies_);
    for (std::size_t k = 0; k < count; ++k) add(fresh.state(k));
  }

 private:
  RigidBodyWorld bodies_;
};

TEST(Resting, AStackOfFiveStaysForTenMinutes) {
  Stack stack(5);
  std::vector<BodyState> starts;
  for (std::size_t k = 0; k < 5; ++k) starts.push_back(stack.bodies().state(k));
  stack.step(10 * kMinute);
  for (std::size_t k = 0; k < 5; ++k) {
    const Pose now = stack.bodies().state(k).world_from_body, start = starts[k].world_from_body;
    EXPECT_LT((now.position_m - start.position_m).norm(), 1e-6) << k;
    EXPECT_LT(now.orientation.angularDistance(start.orientation), 1e-6) << k;
    EXPECT_NEAR(now.position_m.z(), kBed_m + kHeight_m * (0.5 + static_cast<double>(k)), 0.01) << k;
    EXPECT_TRUE(stack.bodies().in_contact(k));
  }
}

TEST(Resting, FrictionHoldsAStackUnderLoadsThatChangeAtEveryStep) {
  Stack stack(3);
  const Eigen::Vector3d starts[] = {stack.place_m(0), stack.place_m(1), stack.place_m(2)};
  for (std::size_t k = 0; k < 2000; ++k) {
    stack.pull(1, 0.9 * kFriction * weight_in_water_n() * std::sin(0.01 * static_cast<double>(k)));
    stack.step(1);
    for (std::size_t body = 0; body < 3; ++body) ASSERT_EQ(stack.place_m(body), starts[body]) << body << " at " << k;
  }
  stack.pull(2, 1.1 * kFriction * weight_in_water_n());  // the topmost block
  stack.step(200);
  EXPECT_GT(stack.place_m(2).x() - starts[2].x(), 0.05);
  EXPECT_LT((stack.place_m(0) - starts[0]).norm(), 1e-6);
}

TEST(Resting, WhatIsRememberedOfAStackChangesNoBit) {
  const auto pulled = [](bool forgets) {
    Stack stack(3);
    std::vector<double> places_m;
    for (std::size_t k = 0; k < 300; ++k) {
      if (forgets) stack.forget(3);
      stack.pull(
          1, 3 * kFriction * weight_in_water_n() * static_cast<double>(k / 4 * 4) / 300);  // constant for four steps
      stack.step(1);
      for (std::size_t body = 0; body < 3; ++body) places_m.push_back(stack.place_m(body).x());
    }
    return places_m;
  };
  const std::vector<double> places_m = pulled(false);
  EXPECT_EQ(places_m, pulled(true));
  EXPECT_GT(places_m.back() - places_m[2], 0.001);
}

/// A row of blocks that sleep until one is pushed against the next, and a block that tumbles along the row, in parts of
/// a step.
TEST(Resting, WhetherBodiesSleepChangesNoBitOfTheSavedState) {
  constexpr double kLong_s = 0.02;
  const auto states_of = [](bool forgets) {
    RigidBodyWorld bodies(flat_bed(kBed_m), kLong_s);
    const auto add = [&](const BodyState& state) { bodies.add_body(body_of(block(), kFriction), state); };
    for (int k = 0; k < 12; ++k) add(at(1.7 * k - 14, 3, kBed_m + kHeight_m / 2 + 0.01));
    BodyState fast = at(13, 3.1, kBed_m + 4);
    add(fast);
    fast.velocity_body << -15, 0, -5, 0, 25, 0;
    std::vector<std::string> states;
    for (int k = 0; k < 500; ++k) {
      bodies.set_wrench(0, ahead(k > 100 && k < 200 ? 1.5 * weight_in_water_n() : 0));
      if (k == 250) bodies.set_state(12, fast);
      bodies.step(EvenWater{}, k * kLong_s);
      states.push_back(saved(bodies));
      if (forgets) restore(bodies, states.back());
    }
    EXPECT_GT(place_m(bodies, 1).x(), -12.6) << "the push reached the second block";
    EXPECT_LT(place_m(bodies, 12).x(), 3) << "the fast block passed some";
    return states;
  };
  EXPECT_EQ(states_of(false), states_of(true));
}

TEST(Resting, ABodyFallsWhenWhatHoldsItUpIsTakenAway) {
  for (const bool is_docked : {false, true}) {
    Stack stack(3);
    const double before_m = stack.place_m(2).z();
    if (is_docked) {
      stack.bodies().hold(1, true);
    } else {
      stack.bodies().set_state(1, at(15, 15, -5));
    }
    stack.step(400);
    EXPECT_LT(stack.place_m(2).z(), before_m - 0.3) << is_docked;
  }
}

TEST(Resting, ABlockThatSleepsOnTheShoreFloatsWhenTheTideRises) {
  constexpr double kShore_m = 0.2, kPeriod_s = 400, kTide_m = 1;
  Water water;
  water.tide = std::make_shared<const Tide>(
      std::vector<TidalConstituent>{{kTide_m, 2 * std::numbers::pi / kPeriod_s, std::numbers::pi / 2}});
  RigidBodyWorld bodies(flat_bed(kShore_m), kStep_s);
  bodies.add_body(body_of(block(500), kFriction), at(0, 0, kShore_m + kHeight_m / 2));
  run(bodies, static_cast<int>(kPeriod_s / 4 / kStep_s), water);
  EXPECT_NEAR(place_m(bodies).z(), kTide_m, 0.05);
}

TEST(Resting, ABlowMovesAStackAndItComesToRestAgain) {
  Stack stack(3);
  const Eigen::Vector3d before = stack.place_m(2);
  BodyState coming = at(-2, 0, stack.place_m(2).z());
  coming.velocity_body[0] = 2;
  stack.add(coming);
  stack.step(400);
  EXPECT_GT(stack.place_m(2).x() - before.x(), 0.01);
  stack.step(3 * kMinute);
  const Eigen::Vector3d after = stack.place_m(2);
  stack.step(kMinute);
  EXPECT_EQ(stack.place_m(2), after);
}

}  // namespace
}  // namespace uwsim
