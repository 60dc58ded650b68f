#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "uwsim/acoustics/sound_speed_profile.h"
#include "uwsim/core/body_state.h"
#include "uwsim/core/parameter.h"
#include "uwsim/core/random.h"
#include "uwsim/rays/ray_scene.h"
#include "uwsim/sensors/sensor_spec.h"
#include "uwsim/world/water.h"
#include "uwsim/world/world.h"

namespace uwsim {

/// The state of a vehicle at a tick, as required by sensors. A sample may be computed later, so it depends only on
/// this, on the world and on functions of time; bodies that move are observed at once (NoisySensor::record).
struct VehicleSnapshot {
  std::uint64_t tick = 0;
  BodyState state;
  Vector6d acceleration_body = Vector6d::Zero();  ///< rate of change of velocity_body, body axes
  bool touching = false;
  Eigen::Vector3d station_world_m = Eigen::Vector3d::Zero();  ///< which may ride on a vehicle
};

/// The surroundings of a vehicle; `scene` contains the other vehicles at their present poses.
struct Surroundings {
  RayScene scene;
  const Water& water;
  const SoundSpeedProfile& sound;  ///< sound speed of the water
  const World* world = nullptr;    ///< whose plants lean otherwise at another time; null if none do
};

/// The input of a measurement.
struct SensorInput {
  const VehicleSnapshot& vehicle;
  const Surroundings& around;
  double time_s;
};

/// The sample before, without noise, of a sensor with a memory.
struct Past {
  std::span<const double> raw;  ///< empty before the first sample
  double elapsed_s;             ///< since that sample
  const RandomStream& draws;    ///< the sensor's own
  std::uint64_t sample;         ///< number of the new sample, which keys its draws
};

/// One quantity of a reading: name, number of values and unit, such as {"orientation_xyzw", 4, "1"}.
struct Field {
  std::string_view name;
  int width;
  std::string_view unit;
};

/// A measured quantity to which noise is added, such as {"angular_velocity", 3, "rad/s"}.
struct Channel {
  std::string_view name;
  int width;
  std::string_view unit;
};

/// A sensor without noise, rate or latency: observe() measures the raw values, distort() adds errors that follow from
/// them, and report() converts them to a reading. Raw values are the channels in order, to which noise is added,
/// followed by noise-free values.
class Sensor {
 public:
  virtual ~Sensor() = default;
  virtual void observe(const SensorInput& input, std::span<double> raw) const = 0;
  /// True if raw values depend on those of the sample before; `follow` then adds that part to what observe() measured.
  /// These values are kept in the sensor's history, so that they are saved and restored with it.
  virtual bool remembers() const { return false; }
  virtual void follow(const SensorInput&, const Past&, std::span<double> /*raw*/) const {}
  /// A cone that encloses the rays that the sensor casts; nullopt if it casts none.
  virtual std::optional<RayCone> rays(const Pose& /*world_from_body*/) const { return std::nullopt; }
  /// Applies errors that depend only on the measured values, such as scale errors, before noise is added.
  virtual void distort(std::span<double>) const {}
  /// Converts raw values to a reading; returns whether it is valid. By default, the reading consists of the raw values.
  virtual bool report(std::span<const double> raw, std::span<double> reading) const {
    std::copy(raw.begin(), raw.end(), reading.begin());
    return true;
  }
  /// The delay until a measurement arrives [s], and its upper limit.
  virtual double travel_time_s(const SensorInput&) const { return 0; }
  virtual double longest_travel_time_s() const { return 0; }
  /// Whether the sensor's ping is sent as a packet over the link's modem, if there is one, so that a sample becomes
  /// available when the answer arrives.
  virtual bool shares_modem() const { return false; }
};

/// A kind of sensor: its name in YAML, its quantities, and its parameters in addition to the common ones.
struct SensorKind {
  std::string_view name;
  std::string_view meaning;
  std::span<const Field> fields;
  std::span<const Channel> channels;
  int noise_free_values;  ///< number of raw values after the channels
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
