#include <gtest/gtest.h>

#include <cmath>

#include "sim/scene.h"

namespace uwsim {
namespace {

constexpr int kBands = 24;
constexpr double kFacet_m = 2.2e-3;  // largest distance between a sphere of radius 1 m and its facets

SensorSpec sensor(const std::string& kind, double rate_hz = 0, double latency_s = 0) {
  SensorSpec spec{.name = kind, .kind = kind, .body_from_sensor = {}, .parameters = {}, .noise = {}};
  if (kind == "proximity") spec.parameters["range_max_m"] = {50};
  spec.rate_hz = rate_hz;
  spec.latency_s = latency_s;
  return spec;
}

/// A sphere of radius 1 m as a hull, neutrally buoyant, at rest.
VehicleSpec ball(const std::string& name, const Eigen::Vector3d& position_m) {
  VehicleSpec spec = vehicle_of(name, position_m, dragged(testing::sphere(1, kBands)));
  spec.sensors = {sensor("proximity", 10, 0.25), sensor("altitude"), sensor("dvl")};
  spec.sonars.resize(1);
  spec.sonars[0].name = "sonar";
  return spec;
}

Simulation two_balls() {
  Simulation sim = simulation(flat_world());
  sim.add_vehicle(ball("first", {0, 0, -10}));
  sim.add_vehicle(ball("second", {10, 0, -10}));
  return sim;
}

void place(Simulation& sim, std::size_t vehicle, const Eigen::Vector3d& position_m) {
  sim.set_state(vehicle, at(position_m));
}

TEST(VehiclesSeeEachOther, ASphereGivesAFanTheRangesOfItsClosedForm) {
  Simulation sim = two_balls();
  const std::vector<float>& angles = sim.sonar(0, 0).multibeam().angles_rad();
  for (const double distance_m : {10.0, 23.5, 5.0}) {
    place(sim, 1, {distance_m, 0, -10});
    const MultibeamPing ping = sim.ping(0, 0);
    int on_sphere = 0;
    for (std::size_t k = 0; k < angles.size(); ++k) {
      const double aside_m = distance_m * std::abs(std::sin(angles[k]));
      if (aside_m > 1 - 0.05) {
        EXPECT_TRUE(aside_m <= 1 || ping.labels[k] != 3) << "beside it";
        continue;
      }
      EXPECT_EQ(ping.labels[k], 3) << "nothing, terrain, the first vehicle, this one";
      const double range_m = distance_m * std::cos(angles[k]) - std::sqrt(1 - aside_m * aside_m);
      EXPECT_NEAR(ping.ranges_m[k], range_m, 10 * kFacet_m);
      ++on_sphere;
    }
    EXPECT_GT(on_sphere, 10);
  }
}

TEST(VehiclesSeeEachOther, NoneSeesItself) {
  Simulation sim = two_balls();
  place(sim, 1, {0, 0, -150 + 200.0});  // far above
  for (const Label label : sim.ping(0, 0).labels) EXPECT_NE(label, 2);
  Simulation alone = simulation(flat_world());
  alone.add_vehicle(ball("first", {0, 0, -10}));
  EXPECT_EQ(sim.ping(0, 0).ranges_m, alone.ping(0, 0).ranges_m);
  EXPECT_EQ(sim.read_sensor(0, 1).values, alone.read_sensor(0, 1).values);
}

TEST(VehiclesSeeEachOther, TheyLieUnderAltimetersAndDvls) {
  Simulation sim = two_balls();
  EXPECT_NEAR(sim.read_sensor(0, 1).values[0], -10 - kBed_m, 1e-9);
  const double bed_range_m = sim.read_sensor(0, 2).values[3];
  place(sim, 1, {0, 0, -15});
  EXPECT_NEAR(sim.read_sensor(0, 1).values[0], 4, 1e-9) << "its top is a vertex";
  EXPECT_NEAR(sim.read_sensor(0, 2).values[3], bed_range_m, 1e-9) << "beams at 30 degrees pass the sphere";
  place(sim, 1, {0, 0, -11.5});
  EXPECT_LT(sim.read_sensor(0, 2).values[3], 1.5);
}

TEST(VehiclesSeeEachOther, ASampleShowsWhereTheOtherWasWheneverItIsRead) {
  Simulation often = two_balls(), seldom = two_balls();
  std::vector<double> seen;
  for (int k = 0; k < 200; ++k) {  // 1 s; the other vehicle moves away by 1 cm per step
    for (Simulation* sim : {&often, &seldom}) {
      place(*sim, 1, {10 + 0.01 * k, 0, -10});
      sim->step();
    }
    const Sample& sample = often.read_sensor(0, 0);
    if (!sample.valid) continue;
    const double then_s = 1e-9 * static_cast<double>(sample.stamp_ns);
    ASSERT_NEAR(sample.values[0], 9 + 0.01 * then_s / 0.005, 1e-9) << "at the time of its stamp";
    seen = sample.values;
  }
  ASSERT_FALSE(seen.empty());
  EXPECT_EQ(seldom.read_sensor(0, 0).values, seen);
  // If the state is saved while the sample is in transit, the same sample arrives after a restore.
  Simulation restored = two_balls();
  restored.restore_state(seldom.save_state(kHere), kHere);
  for (int k = 0; k < 60; ++k) {
    seldom.step(1);
    restored.step(1);
    place(seldom, 1, {30, 0, -10});
    place(restored, 1, {30, 0, -10});
    ASSERT_EQ(restored.read_sensor(0, 0).values, seldom.read_sensor(0, 0).values);
  }
  EXPECT_EQ(restored.ping(0, 0).ranges_m, seldom.ping(0, 0).ranges_m);
}

}  // namespace
}  // namespace uwsim
