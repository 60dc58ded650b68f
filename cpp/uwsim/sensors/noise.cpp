#include "uwsim/sensors/noise.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "uwsim/core/stream_name.h"

namespace uwsim {

Noise::Noise(const SensorKind& kind, const SensorSpec& spec, std::uint64_t seed, const std::string& stream,
             double sample_period_s)
    : white_(seed, stream) {
  const RandomStream turn_on(seed, stream_name(stream, "turn_on")), bias(seed, stream_name(stream, "bias")),
      walk(seed, stream_name(stream, "walk")), flicker(seed, stream_name(stream, "flicker"));
  for (const Channel& channel : kind.channels) {
    const auto found = spec.noise.find(channel.name);
    const NoiseSpec noise = found == spec.noise.end() ? NoiseSpec{} : found->second;
    for (int k = 0; k < channel.width; ++k) {
      const auto index = static_cast<std::uint32_t>(components_.size());
      Component component{std::hypot(noise.std, noise.density / std::sqrt(sample_period_s)),
                          noise.turn_on_std * turn_on.normal(0, index),
                          std::nullopt,
                          std::nullopt,
                          {},
                          noise.quantum,
                          noise.limit_low,
                          noise.limit_high};
      if (noise.bias_std > 0) {
        component.bias = RandomPath::gauss_markov(bias, index, noise.bias_std, noise.bias_time_s / sample_period_s);
      }
      if (noise.walk > 0) {
        component.walk = RandomPath::random_walk(walk, index, noise.walk * std::sqrt(sample_period_s));
      }
      if (noise.instability > 0) {
        constexpr auto kTimes = static_cast<std::uint32_t>(std::size(NoiseSpec::kFlickerTimes_s));
        for (std::uint32_t t = 0; t < kTimes; ++t) {
          const double steps = NoiseSpec::kFlickerTimes_s[t] / sample_period_s;
          if (steps < 1) continue;  // it would be white noise in the samples
          component.flicker.push_back(RandomPath::gauss_markov(flicker, index * kTimes + t, noise.instability, steps));
        }
      }
      components_.push_back(std::move(component));
    }
  }
}

void Noise::apply(std::uint64_t sample, std::span<double> raw) {
  for (std::size_t k = 0; k < components_.size(); ++k) {
    if (!std::isfinite(raw[k])) continue;  // not a measurement, so limits do not apply
    Component& c = components_[k];
    double value = raw[k] + c.turn_on;
    if (c.bias) value += c.bias->at(sample);
    if (c.walk) value += c.walk->at(sample);
    for (RandomPath& path : c.flicker) value += path.at(sample);
    if (c.white_std > 0) value += c.white_std * white_.normal(sample, static_cast<std::uint32_t>(k));
    if (c.quantum > 0) value = c.quantum * std::round(value / c.quantum);
    raw[k] = std::clamp(value, c.limit_low, c.limit_high);
  }
}

}  // namespace uwsim
