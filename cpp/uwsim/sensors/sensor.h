#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "uwsim/core/body_state.h"
#include "uwsim/core/random.h"
#include "uwsim/world/ray_scene.h"
#include "uwsim/world/water.h"

namespace uwsim {

/// A vehicle's sensor as its YAML names it.
struct SensorSpec {
  std::string name;  ///< such as "proximity_port"
  std::string kind;  ///< one of sensor_kinds()
  Pose body_from_sensor;
  double range_max_m = 0;  ///< for the sensors that look along a ray
  double noise_std = 0;    ///< white noise on every component, in the sensor's own unit
};

/// What a sensor may look at.
struct SensorInput {
  const BodyState& state;
  const Vector6d& acceleration_body;
  const RayScene& scene;
  const Water& water;
};

/// A named part of a reading, such as {"orientation_xyzw", 4}.
struct Field {
  std::string_view name;
  int width;
};

/// One kind of sensor: what its reading holds and how it is computed, free of noise.
class Sensor {
 public:
  virtual ~Sensor() = default;
  virtual std::span<const Field> fields() const = 0;
  virtual void measure(const SensorInput& input, std::span<double> out) const = 0;
  /// How many of the values, counted from the front, carry noise.
  virtual std::size_t noisy_values() const { return width(); }
  std::size_t width() const;
};

/// A sensor and its own noise stream. Reading twice at one tick gives the same sample.
class NoisySensor {
 public:
  /// Throws InvalidValue for an unknown kind or a value out of range.
  NoisySensor(const SensorSpec& spec, std::uint64_t seed, std::string_view vehicle);
  const SensorSpec& spec() const { return spec_; }
  const Sensor& sensor() const { return *sensor_; }
  std::vector<double> read(const SensorInput& input, std::uint64_t tick, bool with_noise = true) const;

 private:
  SensorSpec spec_;
  std::unique_ptr<Sensor> sensor_;
  RandomStream noise_;
};

/// The kinds that are built in, one file each in this folder.
std::vector<std::string> sensor_kinds();

}  // namespace uwsim
