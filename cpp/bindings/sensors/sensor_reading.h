#pragma once

#include <pybind11/pybind11.h>
#include <pybind11/typing.h>

#include <cstdint>

#include "uwsim/sensors/noisy_sensor.h"

namespace uwsim::bindings {

/// A sample as exposed to Python: {field: float or (n,) float64}.
struct SensorReading {
  pybind11::typing::Dict<pybind11::str, pybind11::object> values;
  std::uint64_t stamp_ns;
  bool valid;
};

SensorReading sensor_reading(const SensorKind& kind, const Sample& sample);

}  // namespace uwsim::bindings
