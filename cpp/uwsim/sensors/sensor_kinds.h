#pragma once

#include <span>

#include "uwsim/sensors/sensor.h"

namespace uwsim {

/// The built-in kinds, one file each in this folder.
std::span<const SensorKind* const> sensor_kinds();

/// Throws InvalidValue that lists the known names; `path`: the key in the message.
const SensorKind& sensor_kind(std::string_view name, const std::string& path = "kind");

/// The spec with the defaults of its kind filled in. Throws InvalidValue for an unknown parameter or channel, or a
/// value out of range.
SensorSpec completed(SensorSpec spec, const SensorKind& kind);

}  // namespace uwsim
