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

/// The band of the table, in units of the peak frequency. Less than 1e-8 of the energy and 1e-4 of the second moment
/// lie outside it.
constexpr double kLowest = 0.5, kHighest = 300;
constexpr int kSteps = 2048;

/// The fraction of the spectrum's second moment that the components have.
constexpr double kSecondMoment = 0.992;

/// Above this, surface tension is no longer small compared with gravity: for waves of 3.5 cm, its effect is 1/4 of
/// gravity's [rad/s].
constexpr double kShortestGravityWave_rad_s = 42;

/// Limit of the significant steepness for peak periods up to 8 s (DNV-RP-C205, 3.5.5), expressed as the ratio of
/// wavelength to height.
constexpr double kLengthOverHeightMin = 15;

/// JONSWAP's spectrum, unscaled, at x = omega / omega_p.
double jonswap_spectrum(double x, double peak_enhancement) {
  const double sigma = x <= 1 ? 0.07 : 0.09;
  const double b = std::exp(-(x - 1) * (x - 1) / (2 * sigma * sigma));
  return std::pow(x, -5) * std::exp(-1.25 * std::pow(x, -4)) * std::pow(peak_enhancement, b);
}

/// The ratio of the spectrum on water of this depth to that on deep water, if both have the same density in wave
/// number.
double depth_factor(double omega_rad_s, double depth_m, double gravity_m_s2) {
  constexpr double kDeep = 20;  // tanh is 1 to the last digit
  if (omega_rad_s * omega_rad_s * depth_m > kDeep * gravity_m_s2) return 1;
  const double kh = wave_number_rad_m(omega_rad_s, depth_m, gravity_m_s2) * depth_m;
  const double tanh = std::tanh(kh);
  return tanh * tanh / (1 + 2 * kh / std::sinh(2 * kh));
}

/// The energy of a spectrum below a frequency, and its second moment, by the trapezium rule at evenly spaced logarithms
/// of the frequency.
class CumulatedSpectrum {
 public:
  struct Sum {
    double energy, second;
  };

  template <typename Spectrum>
  explicit CumulatedSpectrum(Spectrum spectrum) {
    Sum last{}, sum{};
    for (int k = 0; k <= kSteps; ++k) {
      const double x = kLowest * std::exp(k * kStep), energy = x * spectrum(x);
      const Sum next{energy, x * x * energy};
      if (k > 0) sum = {sum.energy + last.energy + next.energy, sum.second + last.second + next.second};
      sums_.push_back(sum);
      last = next;
    }
  }

  /// Cuts the spectrum above a frequency, or where the given part of the second moment is reached.
  void cut(double highest_x, double part_of_second) {
    const double second = part_of_second * sums_.back().second;
    std::size_t end = 1;
    while (end + 1 < sums_.size() && kLowest * std::exp(static_cast<double>(end) * kStep) < highest_x &&
           sums_[end].second < second) {
      ++end;
    }
    sums_.resize(end + 1);
  }

  const Sum& total() const { return sums_.back(); }

  /// The sums below the frequency at which the mean of the two, each as a fraction of its total, is `u`.
  Sum below(double u) const {
    const auto part = [this](const Sum& sum) {
      return 0.5 * (sum.energy / total().energy + sum.second / total().second);
    };
    const auto next = std::upper_bound(sums_.begin() + 1, sums_.end() - 1, u,
                                       [&](double target, const Sum& sum) { return target < part(sum); });
    const Sum &low = *(next - 1), &high = *next;
    const double step = part(high) - part(low), at = step > 0 ? (u - part(low)) / step : 0;
    return {low.energy + at * (high.energy - low.energy), low.second + at * (high.second - low.second)};
  }

 private:
  inline static const double kStep = std::log(kHighest / kLowest) / kSteps;
  std::vector<Sum> sums_;
};

/// The density of a wave's direction about the heading, and its quantiles: tabulated by the trapezium rule, linear in
/// between.
class Spread {
 public:
  explicit Spread(double exponent) {
    double last = 0;
    for (int k = 0; k <= kAngles; ++k) {
      const double next = std::pow(std::cos(kLow_rad + k * kStep_rad), exponent);
      if (k > 0) below_.push_back(below_.back() + 0.5 * (last + next));
      last = next;
    }
  }

  /// The quantile at probability `u`, in [0, 1).
  double quantile_rad(double u) const {
    const double target = u * below_.back();
    const auto next = std::upper_bound(below_.begin() + 1, below_.end() - 1, target);
    const double last = *(next - 1);
    const double part = *next > last ? (target - last) / (*next - last) : 0;
    return kLow_rad + (static_cast<double>(next - below_.begin() - 1) + part) * kStep_rad;
  }

 private:
  static constexpr int kAngles = 400;
  static constexpr double kLow_rad = -0.5 * std::numbers::pi, kStep_rad = std::numbers::pi / kAngles;
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
  CumulatedSpectrum spectrum([&](double x) {
    return jonswap_spectrum(x, sea.peak_enhancement) * depth_factor(x * peak, depth_m, gravity_m_s2);
  });
  spectrum.cut(kShortestGravityWave_rad_s / peak, kSecondMoment);
  const Spread spread(sea.spreading_exponent);
  const double scale = sea.significant_height_m / 4 * std::sqrt(2 / spectrum.total().energy);
  std::vector<WaveComponent> waves;
  CumulatedSpectrum::Sum below{};
  for (int k = 0; k < sea.component_count; ++k) {
    const auto tick = static_cast<std::uint64_t>(k);
    const bool last = k + 1 == sea.component_count;
    const CumulatedSpectrum::Sum to =
        last ? spectrum.total() : spectrum.below((k + draw.uniform(tick, 0)) / (sea.component_count - 1));
    const double energy = to.energy - below.energy, second = to.second - below.second;
    below = to;
    if (!(energy > 0)) continue;
    const double amplitude_m = scale * std::sqrt(energy);
    waves.push_back(
        {.amplitude_m = amplitude_m,
         .angular_frequency_rad_s =
             std::min(std::sqrt(second / energy) * peak, steepest_frequency(amplitude_m, depth_m, gravity_m_s2)),
         .heading_rad = sea.heading_rad + (sea.spreading_exponent > 0 ? spread.quantile_rad(draw.uniform(tick, 2)) : 0),
         .phase_rad = 2 * std::numbers::pi * draw.uniform(tick, 1)});
  }
  return Waves(waves, depth_m, gravity_m_s2);
}

}  // namespace uwsim
