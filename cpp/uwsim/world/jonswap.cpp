#include <algorithm>
#include <cmath>
#include <numbers>

#include "uwsim/core/check.h"
#include "uwsim/core/random.h"
#include "uwsim/core/stream_name.h"
#include "uwsim/world/waves.h"

namespace uwsim {
namespace {

/// Band of the components, in units of the peak frequency. It holds 99 % of a JONSWAP sea's energy; scaling to the
/// significant height makes up for the rest.
constexpr double kLowest = 0.5, kHighest = 3.0;

/// Limit of the significant steepness for peak periods up to 8 s (DNV-RP-C205, 3.5.5), as wave length over height.
constexpr double kLengthOverHeightMin = 15;

/// The unscaled spectrum at x = omega / omega_p.
double spectrum(double x, double peak_enhancement) {
  const double sigma = x <= 1 ? 0.07 : 0.09;
  const double b = std::exp(-(x - 1) * (x - 1) / (2 * sigma * sigma));
  return std::pow(x, -5) * std::exp(-1.25 * std::pow(x, -4)) * std::pow(peak_enhancement, b);
}

/// Quantile `u` of the distribution cos^n over [-pi/2, pi/2], by the trapezium rule and inversion.
double spread_angle(double u, double exponent) {
  constexpr int kSteps = 400;
  constexpr double kStep = std::numbers::pi / kSteps;
  const auto lobe = [exponent](int k) { return std::pow(std::cos((k - kSteps / 2) * kStep), exponent); };
  double total = 0;
  for (int k = 1; k < kSteps; ++k) total += lobe(k);
  double sum = 0;
  for (int k = 1; k < kSteps; ++k) {
    const double next = sum + lobe(k) / total;
    if (next >= u) return (k - 0.5 + (u - sum) / (next - sum) - kSteps / 2) * kStep;
    sum = next;
  }
  return 0.5 * std::numbers::pi;
}

void check(const JonswapSea& sea, double gravity_m_s2) {
  require(sea.significant_height_m >= 0 && sea.significant_height_m <= 20, "water.surface.significant_height_m",
          sea.significant_height_m, "must be in [0, 20] m");
  require(sea.peak_period_s >= 0.5 && sea.peak_period_s <= 30, "water.surface.peak_period_s", sea.peak_period_s,
          "must be in [0.5, 30] s");
  const double peak_length_m = gravity_m_s2 * sea.peak_period_s * sea.peak_period_s / (2 * std::numbers::pi);
  require(sea.significant_height_m <= peak_length_m / kLengthOverHeightMin, "water.surface.significant_height_m",
          sea.significant_height_m, "m: the sea would break: at most a 15th of the peak's deep-water wave length");
  require(sea.peak_enhancement >= 1 && sea.peak_enhancement <= 10, "water.surface.peak_enhancement",
          sea.peak_enhancement, "must be in [1, 10]");
  require(sea.component_count >= 8 && sea.component_count <= 512, "water.surface.component_count", sea.component_count,
          "must be in [8, 512]");
  require(sea.spreading_exponent >= 0 && sea.spreading_exponent <= 100, "water.surface.spreading_exponent",
          sea.spreading_exponent, "must be in [0, 100]");
}

}  // namespace

Waves Waves::jonswap(const JonswapSea& sea, double depth_m, double gravity_m_s2) {
  check(sea, gravity_m_s2);
  // Each wave has a random frequency in one of equal bins, so that the sea does not repeat.
  const RandomStream draw(sea.seed, stream_name("water", "waves"));
  const double peak = 2 * std::numbers::pi / sea.peak_period_s;
  const double width = (kHighest - kLowest) / sea.component_count;
  std::vector<WaveComponent> waves;
  double variance = 0;
  for (int k = 0; k < sea.component_count; ++k) {
    const auto tick = static_cast<std::uint64_t>(k);
    const double x = kLowest + width * (k + draw.uniform(tick, 0));
    const double energy = spectrum(x, sea.peak_enhancement) * width;
    const double spread = sea.spreading_exponent > 0 ? spread_angle(draw.uniform(tick, 2), sea.spreading_exponent) : 0;
    waves.push_back({.amplitude_m = std::sqrt(2 * energy),
                     .angular_frequency_rad_s = x * peak,
                     .heading_rad = sea.heading_rad + spread,
                     .phase_rad = 2 * std::numbers::pi * draw.uniform(tick, 1)});
    variance += energy;
  }
  const double scale = sea.significant_height_m / (4 * std::sqrt(variance));
  for (WaveComponent& w : waves) w.amplitude_m *= scale;
  return Waves(waves, depth_m, gravity_m_s2);
}

}  // namespace uwsim
