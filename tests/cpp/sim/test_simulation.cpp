#include "uwsim/sim/simulation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "refusal.h"
#include "sim/scene.h"

namespace uwsim {
namespace {

VehicleSpec neutral_vehicle(bool docked = false) {
  VehicleSpec spec = vehicle_of("rov", {0, 0, -8}, dragged());
  spec.actuators.full_wrench_body.setConstant(250);
  spec.docked = docked;
  return spec;
}

Simulation with_neutral_vehicle(const SimulationSpec& spec = {}) {
  Simulation sim = simulation(flat_world(), spec);
  sim.add_vehicle(neutral_vehicle());
  return sim;
}

TEST(Simulation, ADockedVehicleStaysUntilItIsReleased) {
  Simulation sim = simulation(flat_world());
  sim.add_vehicle(neutral_vehicle(true));
  sim.actuators(0).set_effort(Vector6d::Unit(0));
  sim.step(200);
  EXPECT_EQ(sim.state(0).world_from_body.position_m.x(), 0);
  EXPECT_EQ(sim.telemetry(0).mission_time_s, 0);
  sim.release(0);
  sim.step(200);
  EXPECT_GT(sim.state(0).world_from_body.position_m.x(), 0.1);
  EXPECT_NEAR(sim.telemetry(0).mission_time_s, 1, 1e-9);
}

TEST(Simulation, APositiveEffortMovesItsOwnAxisForwardAlone) {
  for (int axis = 0; axis < 6; ++axis) {
    Simulation sim = with_neutral_vehicle();
    sim.actuators(0).set_effort(0.2 * Vector6d::Unit(axis));
    sim.step(100);
    EXPECT_GT(sim.state(0).velocity_body(axis), 0.01);
    Vector6d others = sim.state(0).velocity_body;
    others(axis) = 0;
    EXPECT_LT(others.norm(), 1e-9);
  }
}

TEST(Simulation, ThrustersStopWhenTheBatteryIsEmpty) {
  SimulationSpec spec;
  spec.mission_time_s = 2;
  Simulation sim = with_neutral_vehicle(spec);
  sim.actuators(0).set_effort(Vector6d::Unit(0));
  sim.step(200);
  EXPECT_NEAR(sim.telemetry(0).battery_percent, 50, 1e-9);
  sim.step(200);
  const double speed = sim.telemetry(0).speed_m_s;
  EXPECT_EQ(sim.telemetry(0).battery_percent, 0);
  sim.step(400);
  const double mass_kg = 1000 * 1.2 * 0.8 * 0.6, drag = 250, coasting_s = 2;
  EXPECT_NEAR(sim.telemetry(0).speed_m_s, speed / (1 + drag * speed * coasting_s / mass_kg), 1e-6);
}

TEST(Simulation, APropellerSpinsDownWhenTheBatteryIsEmpty) {
  SimulationSpec spec;
  spec.mission_time_s = 1;
  VehicleSpec vehicle = neutral_vehicle();
  vehicle.actuators = {};
  vehicle.actuators.thrusters.resize(1);
  vehicle.actuators.thrusters[0].time_constant_s = 0.5;
  vehicle.actuators.thrusters[0].curve = ThrustCurve({-1, 1}, {-100, 100});
  Simulation sim = simulation(flat_world(), spec);
  sim.add_vehicle(vehicle);
  sim.actuators(0).set_thrusters({{"", 1}});
  sim.step(200);
  const double full = 100 * (1 - std::exp(-2));
  EXPECT_NEAR(sim.actuators(0).thrusters()[0].thrust_n(), full, 1e-9);
  sim.step(100);
  EXPECT_NEAR(sim.actuators(0).thrusters()[0].thrust_n(), full * std::exp(-1), 1e-9);
}

TEST(Simulation, TelemetryAgreesWithGeometryAndWarnsAtItsThresholds) {
  SimulationSpec spec;
  spec.station_world_m = {0, 60, -8};
  Simulation sim = with_neutral_vehicle(spec);
  Telemetry t = sim.telemetry(0);
  EXPECT_NEAR(t.depth_m, 8, 1e-12);
  EXPECT_NEAR(t.distance_to_seabed_m, 12, 1e-9);
  EXPECT_NEAR(t.distance_to_station_m, 60, 1e-12);
  EXPECT_FALSE(t.range_warning || t.proximity_warning || t.collision_warning);
  BodyState far = at({0, -51, -19.69});
  far.velocity_body << 1, 2, 2, 0, 0, 0.5;
  sim.set_state(0, far);
  t = sim.telemetry(0);
  EXPECT_TRUE(t.range_warning && t.proximity_warning);
  EXPECT_NEAR(t.speed_m_s, 3, 1e-12);
  EXPECT_NEAR(t.angular_speed_rad_s, 0.5, 1e-12);
  far.velocity_body << 0, 0, -0.5, 0, 0, 0;
  sim.set_state(0, far);
  sim.step(5);
  EXPECT_TRUE(sim.telemetry(0).collision_warning);
  EXPECT_EQ(sim.collisions(0), 1u);
}

TEST(Simulation, APositionInsideASolidIsRefused) {
  World world = flat_world();
  world.add_solid("rock", testing::moved(testing::box(4, 4, 4), {10, 0, -8}));
  Simulation sim = simulation(world);
  sim.add_vehicle(neutral_vehicle());
  EXPECT_EQ(refusal([&] {
              sim.set_state(0, at({9, 1, -7}));
            }),
            "vehicle 'rov' position_m =  9  1 -7: must be outside 'rock'");
  EXPECT_EQ(sim.state(0).world_from_body.position_m, Eigen::Vector3d(0, 0, -8)) << "it must stay where it was";
  EXPECT_NO_THROW(sim.set_state(0, at({7.5, 1, -7})));
  VehicleSpec second = neutral_vehicle();
  second.name = "second";
  second.start_world_from_body.position_m = {10, 0, -8};
  EXPECT_THROW(sim.add_vehicle(second), InvalidValue);
}

TEST(Simulation, InvalidCommandsStatesAndSpecsAreRefused) {
  Simulation sim = with_neutral_vehicle();
  EXPECT_THROW(sim.actuators(0).set_effort(Vector6d::Constant(1.01)), InvalidValue);
  EXPECT_THROW(sim.actuators(0).set_effort(Vector6d::Constant(NAN)), InvalidValue);
  BodyState state;
  state.velocity_body(3) = INFINITY;
  EXPECT_THROW(sim.set_state(0, state), InvalidValue);
  EXPECT_THROW(sim.add_vehicle(neutral_vehicle()), InvalidValue) << "a repeated name";
  SimulationSpec spec;
  spec.step_s = 0;
  EXPECT_THROW(simulation(flat_world(), spec), InvalidValue);
}

}  // namespace
}  // namespace uwsim
