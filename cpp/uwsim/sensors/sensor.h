#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "uwsim/core/body_state.h"
#include "uwsim/sensors/sensor_spec.h"
#include "uwsim/world/ray_scene.h"
#include "uwsim/world/water.h"

namespace uwsim {

/// How a vehicle is and moves at the end of step `tick`.
struct Moment {
  std::uint64_t tick = 0;
  BodyState state;
  Vector6d acceleration_body = Vector6d::Zero();  ///< rate of velocity_body, body axes
  bool touching = false;
};

/// What is around the vehicles.
struct Surroundings {
  const RayScene& scene;
  const Water& water;
  Eigen::Vector3d station_world_m = Eigen::Vector3d::Zero();
};

/// What a sensor may look at.
struct SensorInput {
  const Moment& moment;
  const Surroundings& around;
  double time_s;
};

/// A named part of a reading, such as {"orientation_xyzw", 4, "1"}.
struct Field {
  std::string_view name;
  int width;
  std::string_view unit;
};

/// A part of what is measured that noise acts on, such as {"angular_velocity", 3, "rad/s"}.
struct Channel {
  std::string_view name;
  int width;
  std::string_view unit;
};

/// A figure that a kind of sensor takes beside those that all take.
struct Parameter {
  std::string_view name;
  int width;
  double by_default;  ///< of every component; NaN: must be given
  double low, high;
  std::string_view unit;
  std::string_view meaning;
};

/// One kind of sensor, free of noise, rate and delay: what it measures, and the reading that is made of it.
/// What it measures ("raw") holds the channels in their order, then whatever else the reading takes, free of noise.
class Sensor {
 public:
  virtual ~Sensor() = default;
  virtual void observe(const SensorInput& input, std::span<double> raw) const = 0;
  /// Makes the reading; whether it is valid.
  virtual bool report(std::span<const double> raw, std::span<double> reading) const {
    std::copy(raw.begin(), raw.end(), reading.begin());
    return true;
  }
  /// How long after its moment a measurement arrives [s], and how long at most.
  virtual double travel_time_s(const SensorInput&) const { return 0; }
  virtual double longest_travel_time_s() const { return 0; }
};

struct SensorKind {
  std::string_view name;
  std::string_view meaning;
  std::span<const Field> fields;
  std::span<const Channel> channels;
  int noise_free_values;  ///< raw values after the channels
  std::span<const Parameter> parameters;
  std::unique_ptr<Sensor> (*make)(const SensorSpec& complete);

  std::size_t reading_width() const;
  std::size_t raw_width() const;
};

template <typename S>
std::unique_ptr<Sensor> make_sensor(const SensorSpec& complete) {
  return std::make_unique<S>(complete);
}

}  // namespace uwsim
