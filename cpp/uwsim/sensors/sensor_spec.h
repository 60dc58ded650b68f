#pragma once

#include <Eigen/Core>
#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "uwsim/core/parameter.h"
#include "uwsim/core/pose.h"

namespace uwsim {

/// Errors of one channel of a sensor. All components use the same parameters but are drawn independently. [u]: the
/// channel's unit. Sample k reads limit(quantise(truth + turn-on + Gauss-Markov(k) + walk(k) + flicker(k) + white(k))).
/// A value of zero disables that error. Model and names follow IEEE Std 952-1997, annexes B and C; the Allan variances
/// are in tests/cpp/sensors/test_sensor_noise.cpp.
struct NoiseSpec {
  double std = 0;          ///< white noise per sample [u]
  double density = 0;      ///< white noise N (angle or velocity random walk) [u/sqrt(Hz)]: std = N sqrt(sample rate)
  double turn_on_std = 0;  ///< constant bias, drawn once per run [u]
  double bias_std = 0;     ///< stationary Gauss-Markov bias [u] ...
  double bias_time_s = 0;  ///< ... and its correlation time
  double walk = 0;         ///< random walk from 0 at time 0, K (rate random walk) [u/sqrt(s)]: std(t) = K sqrt(t)
  double instability = 0;  ///< flicker noise: the Allan deviation where it is flat [u], see below
  double quantum = 0;      ///< readings are integer multiples of this [u]
  double limit_low = -std::numeric_limits<double>::infinity();  ///< readings saturate below this [u]
  double limit_high = std::numeric_limits<double>::infinity();

  /// Flicker noise, with the power spectral density h / f, is a superposition of relaxations whose time constants are
  /// spaced evenly on a logarithmic scale (van der Ziel 1950, Physica 16:359). Its Allan variance is 2 ln 2 h (IEEE Std
  /// 952-1997, B.4.1.3, where h = B^2 / pi). If each time constant is 4 times the previous one, each relaxation
  /// therefore has the standard deviation sqrt(h ln 4) = `instability`. With the time constants below, the Allan
  /// deviation is flat within 4 % from 1 s to 4 h.
  static constexpr double kFlickerTimes_s[] = {0.0625, 0.25, 1, 4, 16, 64, 256, 1024, 4096, 16384, 65536};
  /// Standard deviation of the flicker noise, in units of `instability`, if no relaxation is too fast for the samples.
  static constexpr double kFlickerStd = 3.3166247903554;  // the square root of their number

  /// Throws InvalidValue naming the field below `path`.
  void check(const std::string& path) const;
};

/// A sensor of a vehicle.
struct SensorSpec {
  std::string name;  ///< such as "proximity_port"
  std::string kind;  ///< one of sensor_kinds()
  Pose body_from_sensor;
  ParameterValues parameters;                           ///< parameters of the kind, such as range_max_m
  std::map<std::string, NoiseSpec, std::less<>> noise;  ///< by channel
  double rate_hz = 0;                                   ///< sample rate, see SampleClock; 0: every step
  double latency_s = 0;                                 ///< time from a measurement to its arrival
  double drop_out = 0;                                  ///< probability that a sample is lost

  double number(std::string_view parameter) const { return uwsim::number(parameters, parameter); }
  Eigen::Vector3d vector3(std::string_view parameter) const {
    return Eigen::Vector3d::Map(parameters.find(parameter)->second.data());
  }
};

}  // namespace uwsim
