#include "uwsim/sensors/sensor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "meshes.h"
#include "uwsim/core/check.h"

namespace uwsim {
namespace {

class Sensors : public ::testing::Test {
 protected:
  Sensors() {
    world.set_terrain(Heightfield(std::vector<float>(4, -20), 2, 2, 200.0, {-100, -100}));
    TriangleMesh wall = testing::box(1, 1, 40);
    for (auto& v : wall.vertices_m) v += Eigen::Vector3d(0, 6, -20);
    world.add_solid("wall to port", wall);
    scene.emplace(world);
    state.world_from_body.position_m = {0, 0, -12};
  }

  std::vector<double> read(const SensorSpec& spec, std::uint64_t tick = 0) const {
    return NoisySensor(spec, 7, "rov").read({state, acceleration, *scene, world.water}, tick);
  }

  World world;
  std::optional<RayScene> scene;
  BodyState state;
  Vector6d acceleration = Vector6d::Zero();
};

const Pose kPort{{0, 0.5, 0}, Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitZ()))};

TEST_F(Sensors, ScalarsFollowTheWaterAndTheScene) {
  EXPECT_NEAR(read({"depth", "depth", Pose{{0, 0, -0.5}, Eigen::Quaterniond::Identity()}})[0], 12.5, 1e-12);
  EXPECT_NEAR(read({"pressure", "pressure", {}})[0], 101325 + 1000 * 9.80665 * 12, 1e-6);
  EXPECT_NEAR(read({"temperature", "temperature", {}})[0], 15 - 9 * 12.0 / 40, 1e-12);
  EXPECT_NEAR(read({"altitude", "altitude", {}})[0], 8, 1e-9);
  EXPECT_TRUE(std::isinf(read({"altitude", "altitude", {}, 5})[0]));
  EXPECT_NEAR(read({"port", "proximity", kPort, 10})[0], 5, 1e-9);
  EXPECT_EQ(read({"port", "proximity", kPort, 3})[0], 3) << "its range where nothing is nearer, as published";
}

TEST_F(Sensors, AnImuAtRestFeelsGravityAndATurningOneItsCentripetalForce) {
  auto still = read({"imu", "imu", {}});
  EXPECT_NEAR(still[5], 9.80665, 1e-12);
  state.velocity_body(5) = 2;  // yaw
  const auto turning = read({"imu", "imu", Pose{{0.3, 0, 0}, Eigen::Quaterniond::Identity()}});
  EXPECT_NEAR(turning[2], 2, 1e-12);
  EXPECT_NEAR(turning[3], -4 * 0.3, 1e-12);
  state.velocity_body << 1, 0, 0, 0, 0, 2;  // going round a circle at steady speed: v omega to port
  EXPECT_NEAR(read({"imu", "imu", {}})[4], 2, 1e-12);
}

TEST_F(Sensors, NoiseHasItsSpreadAndRepeatsAtOneTick) {
  const SensorSpec spec{"depth", "depth", {}, 0, 0.05};
  EXPECT_EQ(read(spec, 3), read(spec, 3));
  double squares = 0;
  constexpr int n = 20'000;
  for (std::uint64_t tick = 0; tick < n; ++tick) squares += std::pow(read(spec, tick)[0] - 12, 2);
  EXPECT_NEAR(std::sqrt(squares / n), 0.05, 0.05 * 5 / std::sqrt(2.0 * n));
}

TEST_F(Sensors, UnknownKindsAndNegativeNoiseAreRefused) {
  EXPECT_THROW(read({"x", "sonnar", {}}), InvalidValue);
  EXPECT_THROW(read({"x", "depth", {}, 0, -1}), InvalidValue);
  EXPECT_THROW(read({"x", "proximity", {}, 0}), InvalidValue);
}

}  // namespace
}  // namespace uwsim
