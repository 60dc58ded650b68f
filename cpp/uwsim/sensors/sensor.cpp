#include "uwsim/sensors/sensor.h"

#include <cmath>
#include <functional>

#include "uwsim/core/check.h"
#include "uwsim/sensors/kinds.h"

namespace uwsim {
namespace {

struct Kind {
  std::string_view name;
  std::unique_ptr<Sensor> (*make)(const SensorSpec&);
};

/// A new sensor is one new file and one line here.
constexpr std::array<Kind, 6> kKinds = {{
    {"imu", make_imu},
    {"depth", make_depth},
    {"pressure", make_pressure},
    {"temperature", make_temperature},
    {"altitude", make_altitude},
    {"proximity", make_proximity},
}};

std::unique_ptr<Sensor> make(const SensorSpec& spec) {
  std::string known;
  for (const Kind& kind : kKinds) {
    if (kind.name == spec.kind) return kind.make(spec);
    known += (known.empty() ? "" : ", ") + std::string(kind.name);
  }
  throw InvalidValue("sensors." + spec.name + ".kind = " + spec.kind + ": must be one of " + known);
}

}  // namespace

std::size_t Sensor::width() const {
  std::size_t total = 0;
  for (const Field& field : fields()) total += static_cast<std::size_t>(field.width);
  return total;
}

NoisySensor::NoisySensor(const SensorSpec& spec, std::uint64_t seed, std::string_view vehicle)
    : spec_(spec), sensor_(make(spec)), noise_(seed, std::string(vehicle) + "/" + spec.name) {
  require(std::isfinite(spec.noise_std) && spec.noise_std >= 0, "sensors." + spec.name + ".noise_std", spec.noise_std,
          "must not be negative");
}

std::vector<double> NoisySensor::read(const SensorInput& input, std::uint64_t tick, bool with_noise) const {
  std::vector<double> values(sensor_->width());
  sensor_->measure(input, values);
  if (with_noise && spec_.noise_std > 0) {
    for (std::size_t k = 0; k < sensor_->noisy_values(); ++k) {
      values[k] += spec_.noise_std * noise_.normal(tick, static_cast<std::uint32_t>(k));
    }
  }
  return values;
}

std::vector<std::string> sensor_kinds() {
  std::vector<std::string> names;
  names.reserve(kKinds.size());
  for (const Kind& kind : kKinds) names.emplace_back(kind.name);
  return names;
}

}  // namespace uwsim
