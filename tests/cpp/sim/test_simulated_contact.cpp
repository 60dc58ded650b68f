// Laws of contact that apply to the whole simulation, regardless of how contacts are found and solved.

#include <gtest/gtest.h>

#include <cmath>

#include "sim/scene.h"
#include "uwsim/core/check.h"

namespace uwsim {
namespace {

constexpr double kRestTolerance_m = 0.01;

struct Block {
  double density_kg_m3 = 2500;
  double friction = 0.5;
  double restitution = 0.1;
  CollisionShape shape = CollisionShape::kHull;
  Eigen::Vector3d mesh_shift_m = Eigen::Vector3d::Zero();
};

/// A 1.2 x 0.8 x 0.6 m box without drag.
VehicleSpec block_at(const Eigen::Vector3d& position_m, const Block& block = {}) {
  const TriangleMesh mesh = testing::moved(brick(), block.mesh_shift_m);
  CraftParameters p = solid_of(mesh, block.density_kg_m3);
  p.centre_of_mass_body_m = block.mesh_shift_m;
  VehicleSpec spec = vehicle_of("block", position_m, craft_of(p, mesh));
  spec.friction = block.friction;
  spec.restitution = block.restitution;
  spec.shape = block.shape;
  spec.actuators.full_wrench_body.setConstant(1000);
  return spec;
}

World shallow_world() {
  World world;
  world.set_terrain(Heightfield(std::vector<float>(81 * 81, -10), 81, 81, 0.5, {-20, -20}));
  return world;
}

Simulation simulated(const VehicleSpec& vehicle, double step_s = 0.005) {
  SimulationSpec spec;
  spec.step_s = step_s;
  Simulation sim = simulation(shallow_world(), spec);
  sim.add_vehicle(vehicle);
  return sim;
}

TEST(SimulatedContact, AFrictionlessBodyKeepsItsSpeedOverAFlatBed) {
  const Block slippery{.friction = 0, .restitution = 0};
  Simulation sim = simulated(block_at({-8.1, 0.3, -9.69}, slippery));
  sim.step(200);
  BodyState state = sim.state(0);
  state.velocity_body << 1, 0, 0, 0, 0, 0;
  sim.set_state(0, state);
  sim.step(1600);
  EXPECT_NEAR(sim.telemetry(0).speed_m_s, 1, 0.01);
}

TEST(SimulatedContact, FrictionIsTheCoefficientTimesTheLoadInEveryDirection) {
  const double mu = 0.5;
  const double load_n = 1.2 * 0.8 * 0.6 * (1100 - 1000) * 9.80665;
  for (const double yaw : {0.0, 0.4, 0.785}) {
    for (const double share : {0.9, 1.15}) {
      VehicleSpec block = block_at({0, 0, -9.69}, {.density_kg_m3 = 1100, .friction = mu, .restitution = 0});
      block.start_world_from_body.orientation = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ());
      Simulation sim = simulated(block);
      sim.step(200);
      const Eigen::Vector3d start = sim.state(0).world_from_body.position_m;
      sim.actuators(0).set_effort(share * mu * load_n / 1000 * Vector6d::Unit(0));
      sim.step(1000);
      const double moved_m = (sim.state(0).world_from_body.position_m - start).norm();
      if (share < 1) {
        EXPECT_LT(moved_m, 0.01) << "holds at yaw " << yaw;
      } else {
        EXPECT_GT(moved_m, 0.1) << "slides at yaw " << yaw;
      }
    }
  }
}

TEST(SimulatedContact, ABodyComesToRestForEveryStepAndShape) {
  for (const double step_s : {0.005, 0.01, 0.02}) {
    for (const CollisionShape shape : {CollisionShape::kHull, CollisionShape::kBox}) {
      const Block block{.shape = shape, .mesh_shift_m = {0.1, 0, 0.25}};
      Simulation sim = simulated(block_at({0, 0, -9.5}, block), step_s);
      sim.step(static_cast<std::uint64_t>(15 / step_s));
      EXPECT_LT(sim.telemetry(0).speed_m_s, 1e-3) << step_s;
      EXPECT_NEAR(sim.state(0).world_from_body.position_m.z() - 0.05, -10, kRestTolerance_m)
          << "the lowest point of the mesh";
    }
  }
}

TEST(SimulatedContact, TheFutureDependsOnTheStateAlone) {
  BodyState start = at({0.2, -0.1, -9.695});
  start.velocity_body << 0.3, 0, -0.2, 0, 0.1, 0;
  std::vector<BodyState> ends;
  for (const int before : {0, 100}) {
    Simulation sim = simulated(block_at({1, 1, -9.69}));
    sim.step(static_cast<std::uint64_t>(before));
    sim.set_state(0, start);
    EXPECT_FALSE(sim.telemetry(0).collision_warning);
    EXPECT_LT(sim.telemetry(0).acceleration_m_s2, 0.1);
    sim.step(200);
    ends.push_back(sim.state(0));
  }
  EXPECT_EQ(ends[0].world_from_body.position_m, ends[1].world_from_body.position_m);
  EXPECT_EQ(ends[0].velocity_body, ends[1].velocity_body);
}

TEST(SimulatedContact, ThrustersGiveNoThrustInAir) {
  VehicleSpec block = block_at({0, 0, 20});
  Simulation sim = simulated(block);
  sim.actuators(0).set_effort(Vector6d::Unit(0));
  sim.step(100);
  EXPECT_EQ(sim.state(0).velocity_body(0), 0);
}

TEST(SimulatedContact, APositionUnderTheGroundOrBeyondTheWorldIsRefused) {
  Simulation sim = simulated(block_at({0, 0, -5}));
  for (const Eigen::Vector3d& place : {Eigen::Vector3d(0, 0, -10.2), Eigen::Vector3d(0, 0, 2e18)}) {
    EXPECT_THROW(sim.set_state(0, at(place)), InvalidValue);
  }
  EXPECT_THROW(sim.state(1), std::out_of_range);
}

TEST(SimulatedContact, InvalidMaterialsAreRefused) {
  for (const Block& bad :
       {Block{.friction = -1}, Block{.friction = NAN}, Block{.restitution = 5}, Block{.restitution = NAN}}) {
    EXPECT_THROW(simulated(block_at({0, 0, -5}, bad)), InvalidValue);
  }
}

}  // namespace
}  // namespace uwsim
