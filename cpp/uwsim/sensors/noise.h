#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "uwsim/core/random_path.h"
#include "uwsim/sensors/sensor.h"

namespace uwsim {

/// The errors of one sensor's channels; see NoiseSpec. What sample k is given depends on seed, sensor and k alone: not
/// on which samples are read, nor how often, nor on other sensors.
class Noise {
 public:
  /// `stream` names the sensor, such as "rov/imu"; `sample_period_s` is what a density is spread over.
  Noise(const SensorKind& kind, const SensorSpec& spec, std::uint64_t seed, const std::string& stream,
        double sample_period_s);

  void apply(std::uint64_t sample, std::span<double> raw);

 private:
  struct Component {
    double white_std;
    double turn_on;
    std::optional<RandomPath> bias, walk;
    double quantum, limit_low, limit_high;
  };

  RandomStream white_;
  std::vector<Component> components_;  ///< of the raw values, from the first
};

}  // namespace uwsim
