#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "uwsim/core/random_path.h"
#include "uwsim/sensors/sensor.h"

namespace uwsim {

/// The errors of one sensor's channels; see NoiseSpec. The errors of sample k depend only on the seed, the sensor and
/// k. They do not depend on which samples are read, on how often they are read, or on other sensors.
class Noise {
 public:
  /// `stream`: identifies the sensor, such as "rov/imu". `sample_period_s` converts a density to a standard deviation.
  Noise(const SensorKind& kind, const SensorSpec& spec, std::uint64_t seed, const std::string& stream,
        double sample_period_s);

  void apply(std::uint64_t sample, std::span<double> raw);

 private:
  struct Component {
    double white_std;
    double turn_on;
    std::optional<RandomPath> bias, walk;
    std::vector<RandomPath> flicker;
    double quantum, limit_low, limit_high;
  };

  RandomStream white_;
  std::vector<Component> components_;  ///< one for each of the first raw values
};

}  // namespace uwsim
