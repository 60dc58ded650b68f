#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "meshes.h"
#include "uwsim/core/check.h"
#include "uwsim/sensors/noisy_sensor.h"
#include "uwsim/sensors/sensor_kinds.h"

namespace uwsim {

/// A flat bed at a depth of 20 m with a wall 5.5 m to port, and one vehicle at a depth of 12 m whose motion the test
/// sets.
class SensorBench : public ::testing::Test {
 protected:
  static constexpr std::uint64_t kStepNs = 5'000'000;
  static constexpr double kStepS = 0.005;

  SensorBench() {
    world.set_terrain(Heightfield(std::vector<float>(4, -20), 2, 2, 400.0, {-200, -200}));
    TriangleMesh wall = testing::box(1, 1, 40);
    for (auto& v : wall.vertices_m) v += Eigen::Vector3d(0, 6, -20);
    world.add_solid("wall to port", wall);
    scene.emplace(world);
    snapshot.state.world_from_body.position_m = {0, 0, -12};
  }

  Surroundings around() const { return {*scene, world.water, sound}; }

  NoisySensor sensor(const SensorSpec& spec, std::uint64_t seed = 7) const { return {spec, seed, "rov", kStepNs}; }

  /// The present reading of a sensor without errors.
  Sample truth(const SensorSpec& spec) const { return sensor(spec).read_true(snapshot, around()); }

  World world;
  std::optional<RayScene> scene;
  SoundSpeedProfile sound = SoundSpeedProfile::even(1480);
  VehicleSnapshot snapshot;
  Eigen::Vector3d& station_world_m = snapshot.station_world_m;
};

inline SensorSpec sensor_spec(const std::string& kind, std::map<std::string, std::vector<double>, std::less<>> p = {},
                              const Pose& body_from_sensor = {}) {
  return {.name = kind, .kind = kind, .body_from_sensor = body_from_sensor, .parameters = std::move(p), .noise = {}};
}

}  // namespace uwsim
