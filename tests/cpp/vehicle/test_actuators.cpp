#include "uwsim/vehicle/actuators.h"

#include <gtest/gtest.h>

#include <cmath>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

FinParameters tail_fin(const char* name, const Eigen::Vector3d& span) {
  FinParameters p;
  p.name = name;
  p.position_body_m = Eigen::Vector3d(-0.7, 0, 0) + 0.1 * span;
  p.span_body = span;
  p.area_m2 = 0.0067;
  p.deflection_max_rad = 0.4;
  return p;
}

/// A propeller and four fins arranged in a cross.
ActuatorsSpec torpedo() {
  ThrusterParameters propeller;
  propeller.name = "propeller";
  propeller.position_body_m = {-0.8, 0, 0};
  propeller.curve = ThrustCurve({-1, 0, 1}, {-30, 0, 50});
  const Eigen::Vector3d y = Eigen::Vector3d::UnitY(), z = Eigen::Vector3d::UnitZ();
  return {.thrusters = {propeller},
          .fins = {tail_fin("port", y), tail_fin("starboard", -y), tail_fin("top", z), tail_fin("bottom", -z)}};
}

BodyState ahead(double speed_m_s) {
  BodyState state;
  state.world_from_body.position_m.z() = -10;
  state.velocity_body(0) = speed_m_s;
  return state;
}

Vector6d settled_wrench(Actuators& actuators, const BodyState& state = ahead(0), const EvenWater& water = {}) {
  for (int k = 0; k < 2000; ++k) actuators.advance(0.005, {true, {}});
  return actuators.wrench_body(state, water, 0, 1);
}

TEST(Actuators, ZeroCommandGivesZeroWrench) {
  Actuators actuators(torpedo());
  EXPECT_TRUE(settled_wrench(actuators).isZero(0));
  actuators.set_effort(Vector6d::Zero());
  EXPECT_TRUE(settled_wrench(actuators).isZero(0));
}

TEST(Actuators, FinsTurnATorpedoAboutEachAxisAlone) {
  Actuators actuators(torpedo());
  EXPECT_EQ(actuators.controllable(), (std::array{true, false, false, true, true, true}));
  for (const int axis : {3, 4, 5}) {
    actuators.set_effort(Vector6d::Unit(axis));
    const Vector6d tau = settled_wrench(actuators, ahead(1.5));
    EXPECT_GT(tau(axis), 0.5);
    Vector6d other_torques = tau;
    other_torques.head<3>().setZero();
    other_torques(axis) = 0;
    EXPECT_LT(other_torques.norm(), 1e-9);
    double largest = 0;
    for (const Fin& fin : actuators.fins()) largest = std::max(largest, std::abs(fin.angle_rad()));
    EXPECT_NEAR(largest, 0.4, 1e-12) << "full effort is full deflection";
  }
  Vector6d all = Vector6d::Zero();
  all.tail<3>().setOnes();
  actuators.set_effort(all);
  settled_wrench(actuators);
  for (const Fin& fin : actuators.fins()) EXPECT_LE(std::abs(fin.angle_rad()), 0.4 + 1e-12);
}

TEST(Actuators, FullEffortIsTheLargestWrenchAheadAndAstern) {
  Actuators actuators(torpedo());
  actuators.set_effort(Vector6d::Unit(0));
  EXPECT_NEAR(settled_wrench(actuators)(0), 50, 1e-9);
  actuators.set_effort(-0.5 * Vector6d::Unit(0));
  EXPECT_NEAR(settled_wrench(actuators)(0), -15, 1e-9);
  EXPECT_NEAR(actuators.full_wrench_body()[1](0), 30, 1e-9);
}

TEST(Actuators, OnlyMotionThroughTheWaterMatters) {
  Actuators actuators(torpedo());
  actuators.set_fins({{"port", 0.2}, {"top", -0.1}});
  EvenWater river;
  river.current_world_m_s = {1, 0, 0};
  EXPECT_LT(settled_wrench(actuators, ahead(1), river).norm(), 1e-12) << "drifting with the water";
  EXPECT_LT((settled_wrench(actuators, ahead(2.5), river) - settled_wrench(actuators, ahead(1.5))).norm(), 1e-12);
}

TEST(Actuators, InAirThereIsNoForce) {
  Actuators actuators(torpedo());
  actuators.set_effort(Vector6d::Ones());
  BodyState flying = ahead(2);
  flying.world_from_body.position_m.z() = 0.5;
  EXPECT_TRUE(settled_wrench(actuators, flying).isZero(0));
  flying.world_from_body.position_m.z() = 0;  // half of the propeller's disc is wet
  actuators.set_wrench(20 * Vector6d::Unit(0));
  actuators.set_fins({});
  flying.velocity_body.setZero();
  EXPECT_NEAR(settled_wrench(actuators, flying)(0), 10, 1e-9);
  ActuatorsSpec direct;
  direct.full_wrench_body.setConstant(10);
  Actuators paper(direct);
  paper.set_effort(Vector6d::Ones());
  paper.advance(0.005, {true, {}});
  EXPECT_NEAR(paper.wrench_body(flying, EvenWater(), 0, 0.25)(2), 2.5, 1e-12);
}

TEST(Actuators, ADirectWrenchCanBeSet) {
  ActuatorsSpec spec;
  spec.full_wrench_body << 100, 50, 50, 10, 0, 10;
  Actuators actuators(spec);
  EXPECT_EQ(actuators.controllable(), (std::array{true, true, true, true, false, true}));
  Vector6d wrench, expected;
  wrench << 40, 25, 0, 0, 3, -5;
  expected << 40, 25, 0, 0, 0, -5;
  actuators.set_wrench(wrench);
  EXPECT_LT((settled_wrench(actuators) - expected).norm(), 1e-12);
  actuators.set_wrench(4 * wrench);
  EXPECT_LT((settled_wrench(actuators) - 2 * expected).norm(), 1e-12) << "sway saturates; the direction is kept";
}

TEST(Actuators, ARefusedCommandChangesNothing) {
  Actuators actuators(torpedo());
  actuators.set_thrusters({{"propeller", 0.5}});
  EXPECT_THROW(actuators.set_thrusters({{"proppeller", 0.1}}), InvalidValue);
  EXPECT_THROW(actuators.set_thrusters({{"propeller", 1.01}}), InvalidValue);
  EXPECT_THROW(actuators.set_thrusters({{"propeller", NAN}}), InvalidValue);
  EXPECT_THROW(actuators.set_fins({{"port", 0.41}}), InvalidValue);
  EXPECT_THROW(actuators.set_fins({{"keel", 0.1}}), InvalidValue);
  EXPECT_THROW(actuators.set_effort(Vector6d::Constant(NAN)), InvalidValue);
  EXPECT_THROW(actuators.set_wrench(Vector6d::Constant(INFINITY)), InvalidValue);
  EXPECT_NEAR(settled_wrench(actuators)(0), 25, 1e-9);
  ActuatorsSpec spec = torpedo();
  spec.fins[1].name = "port";
  EXPECT_THROW(Actuators{spec}, InvalidValue) << "a repeated name";
  spec = torpedo();
  spec.full_wrench_body(0) = 10;
  EXPECT_THROW(Actuators{spec}, InvalidValue) << "a direct wrench and thrusters";
}

}  // namespace
}  // namespace uwsim
