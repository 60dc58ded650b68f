#include "uwsim/sensors/sensor_kinds.h"

#include <array>
#include <cmath>
#include <string>

#include "uwsim/core/check.h"

namespace uwsim {

/// A new sensor is one new file and its kind's name in both of these lists.
extern const SensorKind kImu, kVelocity, kAcceleration, kDepth, kPressure, kTemperature, kAltitude, kProximity, kDvl,
    kUsbl, kCompass, kContact;

namespace {

constexpr std::array kKinds = {&kImu,      &kVelocity,  &kAcceleration, &kDepth, &kPressure, &kTemperature,
                               &kAltitude, &kProximity, &kDvl,          &kUsbl,  &kCompass,  &kContact};

template <typename Named>
std::string names(std::span<const Named> items) {
  std::string text;
  for (const Named& item : items) text += (text.empty() ? "" : ", ") + std::string(item.name);
  return text.empty() ? "none" : text;
}

template <typename Named>
void require_known(std::span<const Named> items, std::string_view name, const std::string& path) {
  for (const Named& item : items) {
    if (item.name == name) return;
  }
  throw InvalidValue(path + " = " + std::string(name) + ": must be one of " + names(items));
}

void require_in_range(const Parameter& parameter, std::span<const double> values, const std::string& path) {
  require(values.size() == static_cast<std::size_t>(parameter.width), path, std::to_string(values.size()) + " values",
          "must have " + std::to_string(parameter.width));
  for (const double value : values) {
    if (value >= parameter.low && value <= parameter.high) continue;
    std::ostringstream message;
    message << path << " = " << value << ' ' << parameter.unit << ": must be in [" << parameter.low << ", "
            << parameter.high << "] " << parameter.unit;
    throw InvalidValue(message.str());
  }
}

}  // namespace

std::size_t SensorKind::reading_width() const {
  std::size_t total = 0;
  for (const Field& field : fields) total += static_cast<std::size_t>(field.width);
  return total;
}

std::size_t SensorKind::raw_width() const {
  auto total = static_cast<std::size_t>(noise_free_values);
  for (const Channel& channel : channels) total += static_cast<std::size_t>(channel.width);
  return total;
}

std::span<const SensorKind* const> sensor_kinds() { return kKinds; }

const SensorKind& sensor_kind(std::string_view name, const std::string& path) {
  std::string known;
  for (const SensorKind* kind : kKinds) {
    if (kind->name == name) return *kind;
    known += (known.empty() ? "" : ", ") + std::string(kind->name);
  }
  throw InvalidValue(path + " = " + std::string(name) + ": must be one of " + known);
}

SensorSpec completed(SensorSpec spec, const SensorKind& kind) {
  const std::string path = "sensors." + spec.name;
  for (const auto& [name, values] : spec.parameters) require_known(kind.parameters, name, path + ".parameters");
  for (const auto& [name, noise] : spec.noise) {
    require_known(kind.channels, name, path + ".channels");
    noise.check(path + "." + name);
  }
  for (const Parameter& parameter : kind.parameters) {
    const std::string name(parameter.name);
    const auto width = static_cast<std::size_t>(parameter.width);
    if (!std::isnan(parameter.by_default)) spec.parameters.try_emplace(name, width, parameter.by_default);
    require(spec.parameters.contains(name), path + "." + name, "missing", "must be given");
    require_in_range(parameter, spec.parameters.at(name), path + "." + name);
  }
  if (spec.parameters.contains("range_min_m")) {
    require(spec.number("range_min_m") < spec.number("range_max_m"), path + ".range_min_m", spec.number("range_min_m"),
            "must be below range_max_m");
  }
  require(spec.rate_hz >= 0 && spec.rate_hz <= 1e5, path + ".rate_hz", spec.rate_hz, "must be in [0, 100000] Hz");
  require(spec.rate_hz == 0 || spec.rate_hz >= 1e-4, path + ".rate_hz", spec.rate_hz, "must be at least 0.0001 Hz");
  require(spec.latency_s >= 0 && spec.latency_s <= 60, path + ".latency_s", spec.latency_s, "must be in [0, 60] s");
  require(spec.drop_out >= 0 && spec.drop_out < 1, path + ".drop_out", spec.drop_out, "must be in [0, 1)");
  return spec;
}

}  // namespace uwsim
