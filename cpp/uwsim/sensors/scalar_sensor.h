#pragma once

#include "uwsim/sensors/sensor.h"

namespace uwsim {

/// A sensor whose reading is one number.
class ScalarSensor : public Sensor {
 public:
  explicit ScalarSensor(std::string_view field) : field_{field, 1} {}
  std::span<const Field> fields() const final { return {&field_, 1}; }
  void measure(const SensorInput& input, std::span<double> out) const final { out[0] = value(input); }

 protected:
  virtual double value(const SensorInput& input) const = 0;

 private:
  Field field_;
};

/// Where the sensor is, in the world.
inline Pose world_from_sensor(const SensorInput& input, const Pose& body_from_sensor) {
  return input.state.world_from_body * body_from_sensor;
}

}  // namespace uwsim
