// Steps allocate nothing. Every malloc of the process is counted, including those of Bullet, Embree and Eigen.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <memory>
#include <utility>
#include <vector>

#include "meshes.h"
#include "sim/counted_allocations.h"
#include "sim/heavy_rov.h"

namespace uwsim {
namespace {

constexpr std::uint64_t kWarmUpSteps = 200;  // buffers grow to the required size
constexpr std::uint64_t kSteps = 1000;
constexpr double kBed_m = -10;

/// An undulating bed about z = -10 m, with cells of 0.5 m and a wall on it.
World uneven_world() {
  std::vector<float> heights;
  for (int j = 0; j < 81; ++j) {
    for (int i = 0; i < 81; ++i) {
      heights.push_back(static_cast<float>(kBed_m + 0.05 * std::sin(0.9 * i) * std::cos(0.7 * j)));
    }
  }
  World world;
  world.set_terrain(Heightfield(std::move(heights), 81, 81, 0.5, {-20, -20}));
  world.add_solid("wall", testing::moved(testing::box(1, 8, 12), {8, 0, kBed_m + 5}));
  return world;
}

World with_waves(World world) {
  world.water.waves =
      std::make_shared<const Waves>(Waves::jonswap({.significant_height_m = 0.3, .component_count = 64}, 10.0));
  return world;
}

class Dive {
 public:
  explicit Dive(const World& world) : sim_(world, std::make_shared<const RayScene>(world), SimulationSpec{}) {}

  std::size_t add(const std::string& name, const Eigen::Vector3d& position_m, double density_kg_m3 = 1000) {
    return sim_.add_vehicle(testing::heavy_rov(name, position_m, density_kg_m3));
  }
  void push(std::size_t vehicle, double surge, double heave = 0, double yaw = 0) {
    Vector6d effort = Vector6d::Zero();
    effort(0) = surge;
    effort(2) = heave;
    effort(5) = yaw;
    sim_.actuators(vehicle).set_effort(effort);
  }
  Simulation& sim() { return sim_; }

  /// The number of allocations in the steps after the warm-up.
  std::uint64_t allocations() {
    sim_.step(kWarmUpSteps);
    const std::uint64_t before = testing::allocations();
    sim_.step(kSteps);
    return testing::allocations() - before;
  }

 private:
  Simulation sim_;
};

TEST(StepAllocatesNothing, TheCounterSeesEveryKindOfAllocation) {
  std::uint64_t before = testing::allocations();
  const auto counted = [&] { return testing::allocations() - std::exchange(before, testing::allocations()); };
  void* volatile kept = std::malloc(10);
  EXPECT_EQ(counted(), 1u);
  std::free(kept);
  kept = std::calloc(2, 10);
  EXPECT_EQ(counted(), 1u);
  kept = std::realloc(kept, 100'000);
  EXPECT_EQ(counted(), 1u);
  std::free(kept);
  kept = std::aligned_alloc(64, 128);
  EXPECT_EQ(counted(), 1u);
  std::free(kept);
  const auto one = std::make_unique<std::vector<double>>(7);
  EXPECT_EQ(counted(), 2u);
  const auto dynamic = std::make_unique<Eigen::VectorXd>(37);
  EXPECT_EQ(counted(), 2u) << "by Eigen";
  Dive dive(uneven_world());
  EXPECT_GE(counted(), 100u) << "by Bullet and Embree, which are shared libraries";
}

TEST(StepAllocatesNothing, InOpenWater) {
  Dive dive(uneven_world());
  dive.push(dive.add("rov", {0, 0, -5}), 0.3, 0.05, 0.1);
  EXPECT_EQ(dive.allocations(), 0u);
}

TEST(StepAllocatesNothing, CrossingTheSurface) {
  Dive dive(uneven_world());
  dive.push(dive.add("rov", {0, 0, 0}, 700), 0.2, -0.1, 0.1);
  EXPECT_EQ(dive.allocations(), 0u);
  const double z_m = dive.sim().state(0).world_from_body.position_m.z();
  EXPECT_LT(std::abs(z_m), 0.2) << "the test needs a vehicle at the surface";
}

TEST(StepAllocatesNothing, InWavesAtTheSurfaceAndBelow) {
  Dive dive(with_waves(uneven_world()));
  dive.push(dive.add("floating", {0, 0, 0}, 700), 0.2);
  dive.push(dive.add("below", {-5, 0, -2}), 0.2);
  EXPECT_EQ(dive.allocations(), 0u);
}

TEST(StepAllocatesNothing, OnATetherThatIsPaidOutOverTheBed) {
  Dive dive(with_waves(uneven_world()));
  TetherSpec tether;
  tether.first.point_m = {-6, 0, -9};
  tether.second.body = dive.add("rov", {0, 0, -5});
  tether.length_m = 12;
  tether.longest_m = 20;
  tether.fastest_m_s = 0.5;
  tether.mass_kg_m = 0.5;
  dive.push(0, 0.3, 0.05, 0.1);
  dive.sim().add_tether(tether);
  dive.sim().tether(0).command({WinchCommand::Mode::kRate, 0.5});
  const std::size_t before = dive.sim().tether(0).elements();
  EXPECT_EQ(dive.allocations(), 0u);
  EXPECT_GT(dive.sim().tether(0).elements(), before);
}

TEST(StepAllocatesNothing, RestingOnTheBed) {
  Dive dive(uneven_world());
  dive.add("rov", {0, 0, kBed_m + 0.4}, 1300);
  EXPECT_EQ(dive.allocations(), 0u);
  EXPECT_TRUE(dive.sim().telemetry(0).collision_warning);
}

TEST(StepAllocatesNothing, HalfAMetreAboveTheBed) {
  Dive dive(uneven_world());
  dive.push(dive.add("rov", {0, 0, kBed_m + 0.65}), 0.1, 0.01, 0.2);
  EXPECT_EQ(dive.allocations(), 0u);
}

TEST(StepAllocatesNothing, DraggedOverTheBedAgainstAWall) {
  Dive dive(uneven_world());
  dive.push(dive.add("rov", {5.5, 0, kBed_m + 0.4}, 1100), 0.8, 0, 0.1);
  EXPECT_EQ(dive.allocations(), 0u);
  EXPECT_TRUE(dive.sim().telemetry(0).collision_warning);
}

TEST(StepAllocatesNothing, TwoVehiclesTouching) {
  Dive dive(uneven_world());
  dive.push(dive.add("one", {-0.3, 0.02, -5}), 0.5);
  const std::size_t other = dive.add("other", {0.3, -0.02, -5});
  dive.push(other, -0.5);
  EXPECT_EQ(dive.allocations(), 0u);
  EXPECT_TRUE(dive.sim().telemetry(other).collision_warning || dive.sim().collisions(other) > 0);
}

TEST(StepAllocatesNothing, WithSensorsRead) {
  Dive dive(with_waves(uneven_world()));
  dive.push(dive.add("rov", {0, 0, -5}), 0.3);
  const std::size_t sensors = dive.sim().vehicle(0).sensors.size();
  const auto fly = [&](std::uint64_t steps) {
    for (std::uint64_t k = 0; k < steps; ++k) {
      dive.sim().step();
      for (std::size_t sensor = 0; sensor < sensors; ++sensor) dive.sim().read_sensor(0, sensor);
    }
  };
  fly(kWarmUpSteps);
  const std::uint64_t before = testing::allocations();
  fly(kSteps);
  EXPECT_EQ(testing::allocations() - before, 0u);
}

}  // namespace
}  // namespace uwsim
