#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "uwsim/core/check.h"
#include "uwsim/core/random.h"
#include "uwsim/core/stream_name.h"
#include "uwsim/core/with_unit.h"
#include "uwsim/world/waves.h"

namespace uwsim {
namespace {

/// Frequency band of the components, in units of the peak frequency. It contains 99 % of a JONSWAP sea's energy;
/// scaling to the significant height compensates for the rest.
constexpr double kLowest = 0.5, kHighest = 3.0;

/// Limit of the significant steepness for peak periods up to 8 s (DNV-RP-C205, 3.5.5), expressed as the ratio of
/// wavelength to height.
constexpr double kLengthOverHeightMin = 15;

/// The unscaled spectrum at x = omega / omega_p.
double spectrum(double x, double peak_enhancement) {
  const double sigma = x <= 1 ? 0.07 : 0.09;
  const double b = std::exp(-(x - 1) * (x - 1) / (2 * sigma * sigma));
  return std::pow(x, -5) * std::exp(-1.25 * std::pow(x, -4)) * std::pow(peak_enhancement, b);
}

/// A probability density over an interval, for computing quantiles. The density's integral is tabulated by the
/// trapezoidal rule and interpolated linearly.
class Distribution {
 public:
  template <typename Density>
  Distribution(double low, double high, int steps, Density density) : low_(low), step_((high - low) / steps) {
    double last = density(low);
    for (int k = 1; k <= steps; ++k) {
      const double next = density(low + k * step_);
      below_.push_back(below_.back() + 0.5 * (last + next));
      last = next;
    }
  }

  /// The quantile of the distribution at probability `u`, in [0, 1).
  double quantile(double u) const {
    const double target = u * below_.back();
    const auto next = std::upper_bound(below_.begin() + 1, below_.end() - 1, target);
    const double last = *(next - 1);
    const double part = *next > last ? (target - last) / (*next - last) : 0;
    return low_ + (static_cast<double>(next - below_.begin() - 1) + part) * step_;
  }

 private:
  double low_, step_;
  std::vector<double> below_ = {0};
};

void check(const JonswapSea& sea, double gravity_m_s2) {
  require(sea.significant_height_m >= 0 && sea.significant_height_m <= 20, "water.surface.significant_height_m",
          sea.significant_height_m, "must be in [0, 20] m");
  require(sea.peak_period_s >= 0.5 && sea.peak_period_s <= 30, "water.surface.peak_period_s", sea.peak_period_s,
          "must be in [0.5, 30] s");
  const double peak_length_m = gravity_m_s2 * sea.peak_period_s * sea.peak_period_s / (2 * std::numbers::pi);
  require(sea.significant_height_m <= peak_length_m / kLengthOverHeightMin, "water.surface.significant_height_m",
          with_unit(sea.significant_height_m, "m"),
          "the sea would break: at most a 15th of the peak's deep-water wave length");
  require(sea.peak_enhancement >= 1 && sea.peak_enhancement <= 10, "water.surface.peak_enhancement",
          sea.peak_enhancement, "must be in [1, 10]");
  require(sea.component_count >= 8 && sea.component_count <= 512, "water.surface.component_count", sea.component_count,
          "must be in [8, 512]");
  require(sea.spreading_exponent >= 0 && sea.spreading_exponent <= 100, "water.surface.spreading_exponent",
          sea.spreading_exponent, "must be in [0, 100]");
}

/// The frequency at which a wave would break, which bounds the tail of a steep sea [rad/s].
double steepest_frequency(double amplitude_m, double depth_m, double gravity_m_s2) {
  if (amplitude_m == 0) return std::numeric_limits<double>::infinity();
  const double k = 0.99 * Waves::kSteepest / amplitude_m;
  return std::sqrt(gravity_m_s2 * k * std::tanh(k * depth_m));
}

}  // namespace

Waves Waves::jonswap(const JonswapSea& sea, double depth_m, double gravity_m_s2) {
  check(sea, gravity_m_s2);
  const RandomStream draw(sea.seed, stream_name("water", "waves"));
  const double peak = 2 * std::numbers::pi / sea.peak_period_s;
  const double amplitude_m = sea.significant_height_m / 4 * std::sqrt(2.0 / sea.component_count);
  const Distribution frequencies(kLowest, kHighest, 4096, [&](double x) { return spectrum(x, sea.peak_enhancement); });
  const Distribution spread(-0.5 * std::numbers::pi, 0.5 * std::numbers::pi, 400,
                            [&](double angle) { return std::pow(std::cos(angle), sea.spreading_exponent); });
  const double steepest_x = steepest_frequency(amplitude_m, depth_m, gravity_m_s2) / peak;
  std::vector<WaveComponent> waves;
  for (int k = 0; k < sea.component_count; ++k) {
    const auto tick = static_cast<std::uint64_t>(k);
    const double x = std::min(frequencies.quantile((k + draw.uniform(tick, 0)) / sea.component_count), steepest_x);
    waves.push_back(
        {.amplitude_m = amplitude_m,
         .angular_frequency_rad_s = x * peak,
         .heading_rad = sea.heading_rad + (sea.spreading_exponent > 0 ? spread.quantile(draw.uniform(tick, 2)) : 0),
         .phase_rad = 2 * std::numbers::pi * draw.uniform(tick, 1)});
  }
  return Waves(waves, depth_m, gravity_m_s2);
}

}  // namespace uwsim
