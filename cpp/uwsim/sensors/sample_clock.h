#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace uwsim {

/// The sampling times of a sensor. Sample k is taken at the first step at or after k / rate, so the mean rate is exact
/// even if it does not divide the step rate. A rate of 0, or above the step rate, means every step.
class SampleClock {
 public:
  SampleClock(double rate_hz, std::uint64_t step_ns) : step_ns_(step_ns), period_ns_(step_ns) {
    if (rate_hz > 0) period_ns_ = std::max(step_ns, static_cast<std::uint64_t>(std::llround(1e9 / rate_hz)));
  }

  bool every_step() const { return period_ns_ == step_ns_; }
  double period_s() const { return 1e-9 * static_cast<double>(period_ns_); }
  std::uint64_t time_ns(std::uint64_t tick) const { return tick * step_ns_; }
  /// The index of the newest sample at a tick.
  std::uint64_t sample_at(std::uint64_t tick) const { return tick * step_ns_ / period_ns_; }
  std::uint64_t tick_of(std::uint64_t sample) const { return (sample * period_ns_ + step_ns_ - 1) / step_ns_; }
  bool samples_at(std::uint64_t tick) const { return tick_of(sample_at(tick)) == tick; }

 private:
  std::uint64_t step_ns_, period_ns_;
};

}  // namespace uwsim
