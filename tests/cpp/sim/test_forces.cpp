#include <gtest/gtest.h>

#include <string>

#include "sim/scene.h"

namespace uwsim {
namespace {

std::shared_ptr<const Craft> block(double density_kg_m3, double drag) {
  CraftParameters p = brick_parameters(density_kg_m3);
  p.centre_of_mass_body_m = {0.02, -0.01, -0.05};
  p.added_mass.diagonal() << 300, 500, 900, 30, 50, 40;
  p.quadratic_damping.diagonal().setConstant(drag);
  return craft_of(p);
}

VehicleSpec vehicle(const std::string& name, const Eigen::Vector3d& position_m, double density_kg_m3 = 1050,
                    double drag = 250) {
  VehicleSpec spec = vehicle_of(name, position_m, block(density_kg_m3, drag));
  ThrusterParameters thruster = aft_thruster();
  thruster.position_body_m = {-0.5, 0.1, 0};
  spec.actuators.thrusters = {thruster};
  return spec;
}

/// A vehicle that falls onto another, which slides down a slope.
Simulation falling() {
  World world;
  world.set_terrain(Heightfield({-20, -19, -20, -19}, 2, 2, 10.0, {-5, -5}));
  Simulation sim = simulation(world);
  sim.add_vehicle(vehicle("first", {0, 0, -19}, 2500));
  sim.add_vehicle(vehicle("second", {0.3, 0.2, -18}, 2500));
  return sim;
}

/// By how much the sum of the forces in the last step differs from the change of momentum [N, N m].
double excess(const Simulation& sim, std::size_t index, const BodyState& before) {
  const Vector6d change = (sim.state(index).velocity_body - before.velocity_body) / sim.spec().step_s;
  const Vector6d excess = sim.forces(index).sum() - sim.vehicle(index).craft->rigid_mass() * change;
  return excess.cwiseAbs().maxCoeff();
}

TEST(Forces, SumToMassTimesAcceleration) {
  Simulation sim = falling();
  sim.actuators(0).set_thrusters({{"aft", 1}});
  sim.apply_wrench(1, Vector6d{30, 0, 0, 0, 5, 5}, true, 2);
  int in_contact = 0, at_rest = 0;
  for (int step = 0; step < 3000; ++step) {
    const BodyState before[] = {sim.state(0), sim.state(1)};
    sim.step();
    for (const std::size_t k : {0u, 1u}) {
      EXPECT_LT(excess(sim, k, before[k]), 1e-8) << "of a weight of 14 kN, step " << step;
      in_contact += sim.touches(k).empty() ? 0 : 1;
      at_rest += sim.state(k).velocity_body.isZero(0) ? 1 : 0;
    }
  }
  EXPECT_GT(in_contact, 1000);
  EXPECT_GT(at_rest, 100);
}

TEST(Forces, OfContactsAreThoseOfTheirPoints) {
  Simulation sim = falling();
  for (int step = 0; step < 3000; ++step) {
    sim.step();
    Eigen::Vector3d between = Eigen::Vector3d::Zero();
    for (const std::size_t k : {0u, 1u}) {
      Eigen::Vector3d force = Eigen::Vector3d::Zero();
      for (const Touch& touch : sim.touches(k)) {
        force += touch.force_world_n;
        if (touch.other != Touch::kNoBody) between += touch.force_world_n;
      }
      const Eigen::Vector3d whole = sim.forces(k).contact.head<3>();
      // The axes turn within a step, and friction holds a little more than contacts do (resting.h).
      EXPECT_LT((sim.state(k).world_from_body.direction(whole) - force).norm(), 0.02 * force.norm() + 60) << step;
    }
    EXPECT_LT(between.norm(), 1e-9) << "action and reaction";
  }
}

TEST(Forces, SurviveASavedState) {
  Simulation sim = falling(), other = falling();
  for (int part = 0; part < 10; ++part) {
    sim.step(137);
    other.restore_state(sim.save_state(kHere), kHere);
    for (const std::size_t k : {0u, 1u}) {
      EXPECT_EQ(sim.forces(k).sum(), other.forces(k).sum());
      EXPECT_EQ(sim.touches(k).size(), other.touches(k).size());
    }
  }
}

TEST(Forces, OfADockAreWhatHoldsTheVehicle) {
  const World world = flat_world();
  Simulation sim = simulation(world);
  VehicleSpec docked = vehicle("docked", {0, 0, -5}, 1200);
  docked.docked = true;
  sim.add_vehicle(docked);
  sim.step(10);
  const Forces forces = sim.forces(0);
  EXPECT_NEAR(forces.dock[2], (1200 - 1000) * 0.576 * world.water.gravity(), 1e-6);
  EXPECT_EQ(forces.sum(), Vector6d::Zero());
}

TEST(AppliedWrench, ChangesMomentumByForceTimesTime) {
  const World world = flat_world();
  Simulation sim = simulation(world);
  VehicleSpec spec = vehicle("pushed", {0, 0, -10}, 1000, 0);
  CraftParameters p = spec.craft->parameters();
  p.centre_of_mass_body_m.setZero();
  spec.craft = craft_of(p);
  const Vector6d push{12, 0, 0, 0, 0, 0};
  spec.wrenches = {{.wrench = push, .from_tick = 100, .until_tick = 200}};  // half a second
  sim.add_vehicle(spec);
  sim.apply_wrench(0, push, true, 1);
  sim.step(1000);
  EXPECT_NEAR(sim.state(0).velocity_body[0], 12 * 1.5 / (p.mass_kg + 300), 1e-12);
}

}  // namespace
}  // namespace uwsim
