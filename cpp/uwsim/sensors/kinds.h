#pragma once

#include <memory>

#include "uwsim/sensors/sensor.h"

/// One maker a kind; each is defined in the file of its name.
namespace uwsim {

std::unique_ptr<Sensor> make_imu(const SensorSpec& spec);
std::unique_ptr<Sensor> make_depth(const SensorSpec& spec);
std::unique_ptr<Sensor> make_pressure(const SensorSpec& spec);
std::unique_ptr<Sensor> make_temperature(const SensorSpec& spec);
std::unique_ptr<Sensor> make_altitude(const SensorSpec& spec);
std::unique_ptr<Sensor> make_proximity(const SensorSpec& spec);

}  // namespace uwsim
