#pragma once

#include <span>

#include "uwsim/sensors/sensor.h"

namespace uwsim {

/// The built-in kinds of sensor, each defined in its own file in this folder.
std::span<const SensorKind* const> sensor_kinds();

/// Returns the kind with this name. Throws InvalidValue listing the known names; `path`: the key named in the message.
const SensorKind& sensor_kind(std::string_view name, const std::string& path = "kind");

/// Returns the spec with the defaults of its kind filled in. Throws InvalidValue for an unknown parameter or channel,
/// or a value out of range.
SensorSpec completed(SensorSpec spec, const SensorKind& kind);

}  // namespace uwsim
