#include "uwsim/sensors/sensor_kinds.h"

#include <array>
#include <string>

#include "uwsim/core/check.h"

namespace uwsim {

/// To add a sensor, add a file and list its kind in both places below.
extern const SensorKind kImu, kPosition, kVelocity, kAcceleration, kDepth, kPressure, kTemperature, kAltitude,
    kProximity, kDvl, kUsbl, kCompass, kContact, kCtd, kGps, kIns, kAdcp, kGyrocompass;

namespace {

constexpr std::array kKinds = {&kImu,         &kPosition, &kVelocity,  &kAcceleration, &kDepth, &kPressure,
                               &kTemperature, &kAltitude, &kProximity, &kDvl,          &kUsbl,  &kCompass,
                               &kContact,     &kCtd,      &kGps,       &kIns,          &kAdcp,  &kGyrocompass};

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

const SensorKind& sensor_kind(std::string_view name, const std::string& path) { return find_kind(kKinds, name, path); }

SensorSpec completed(SensorSpec spec, const SensorKind& kind) {
  const std::string path = "sensors." + spec.name;
  for (const auto& [name, noise] : spec.noise) {
    require_known(name, kind.channels, path + ".channels");
    noise.check(path + "." + name);
  }
  complete_parameters(spec.parameters, kind.parameters, path);
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
