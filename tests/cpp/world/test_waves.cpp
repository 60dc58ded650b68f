#include "uwsim/world/waves.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstdint>
#include <limits>
#include <numbers>
#include <vector>

#include "uwsim/core/check.h"
#include "world/wave_constants.h"

namespace uwsim {
namespace {

constexpr double kDeep = std::numeric_limits<double>::infinity();

Waves airy(double amplitude_m, double period_s, double depth_m, double heading_rad = 0.3) {
  const WaveComponent wave{amplitude_m, 2 * kPi / period_s, heading_rad, 0.7};
  return Waves({&wave, 1}, depth_m);
}

WaterFlow flow(const Waves& waves, const Eigen::Vector3d& p, double t) {
  WaterFlow sum;
  waves.add_flow(p, t, sum);
  return sum;
}

/// Central difference of `f` along `direction`.
template <typename F>
auto slope(F f, const Eigen::Vector3d& p, const Eigen::Vector3d& direction) {
  const double h = 1e-4;
  return ((f(p + h * direction) - f(p - h * direction)) / (2 * h));
}

TEST(Waves, TheDispersionRelationHoldsFromShallowToDeep) {
  for (const double depth : {0.5, 3.0, 30.0, 4000.0}) {
    for (const double omega : {0.06, 0.5, 2.0, 9.0}) {
      const double k = wave_number_rad_m(omega, depth, kGravity);
      EXPECT_NEAR(kGravity * k * std::tanh(k * depth), omega * omega, 1e-12 * omega * omega) << depth << " " << omega;
    }
  }
  EXPECT_NEAR(wave_number_rad_m(0.06, 0.5, kGravity), 0.06 / std::sqrt(kGravity * 0.5), 1e-4) << "shallow: c^2 = g h";
  EXPECT_DOUBLE_EQ(wave_number_rad_m(2.0, kDeep, kGravity), 4 / kGravity);
}

TEST(Waves, TheSurfaceIsWherePressureIsAtmospheric) {
  const Waves sea = Waves::jonswap({.significant_height_m = 1, .peak_period_s = 4, .seed = 3}, 12);
  for (double t = 0; t < 30; t += 0.37) {
    const double height = sea.height_at(3, -2, t);
    EXPECT_NEAR(sea.head_at({3, -2, height}, t), 0, 1e-12);
    EXPECT_NEAR(sea.head_at({3, -2, height + 0.4}, t), -0.4, 1e-12);
    EXPECT_GT(sea.head_at({3, -2, height - 0.01}, t), 0);
  }
}

TEST(Waves, InDeepWaterPressureDecaysExponentiallyAndVanishesAtDepth) {
  const Waves wave = airy(1e-5, 3, kDeep);
  const double k = wave_number_rad_m(2 * kPi / 3, kDeep, kGravity);
  const Eigen::Vector3d p(0, 0, -1);
  EXPECT_NEAR(wave.head_at(p, 0) - 1, 1e-5 * std::cos(0.7) * std::exp(-k), 1e-4 * 1e-5);
  const Eigen::Vector3d abyss(0, 0, -100);
  EXPECT_EQ(wave.head_at(abyss, 0), 100);
  EXPECT_EQ(flow(wave, abyss, 0).velocity_m_s.norm(), 0);
}

TEST(Waves, FlowObeysEulersEquationAndConservesVolume) {
  const Waves wave = airy(1e-4, 5, 8);  // so small that stretching is negligible
  const Eigen::Vector3d p(2, 5, -3);
  const double t = 1.3, k = wave_number_rad_m(2 * kPi / 5, 8, kGravity), scale = 1e-4 * kGravity * k;
  const auto head = [&](const Eigen::Vector3d& at) { return wave.head_at(at, t) + at.z(); };
  const Eigen::Vector3d expected =
      -kGravity * Eigen::Vector3d(slope(head, p, Eigen::Vector3d::UnitX()), slope(head, p, Eigen::Vector3d::UnitY()),
                                  slope(head, p, Eigen::Vector3d::UnitZ()));
  EXPECT_LT((flow(wave, p, t).wave_acceleration_m_s2 - expected).norm(), 1e-3 * scale);
  const Eigen::Vector3d rate = (flow(wave, p, t + 1e-4).velocity_m_s - flow(wave, p, t - 1e-4).velocity_m_s) / 2e-4;
  EXPECT_LT((flow(wave, p, t).wave_acceleration_m_s2 - rate).norm(), 1e-5 * scale);
  double divergence = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto v = [&](const Eigen::Vector3d& at) { return flow(wave, at, t).velocity_m_s(axis); };
    divergence += slope(v, p, Eigen::Vector3d::Unit(axis));
  }
  EXPECT_LT(std::abs(divergence), 1e-3 * scale);
  EXPECT_NEAR(flow(wave, {2, 5, -8}, t).velocity_m_s.z(), 0, 1e-12) << "no flow through the bed";
  const double rise = (wave.height_at(2, 5, t + 1e-4) - wave.height_at(2, 5, t - 1e-4)) / 2e-4;
  EXPECT_NEAR(flow(wave, {2, 5, wave.height_at(2, 5, t)}, t).velocity_m_s.z(), rise, 1e-8);
}

TEST(Waves, AWaveRunsTowardsItsHeadingAtThePhaseSpeed) {
  const Waves wave = airy(0.1, 4, kDeep, kPi / 2);
  const double speed = kGravity * 4 / (2 * kPi);
  EXPECT_NEAR(wave.height_at(0, 0, 0), wave.height_at(7, speed * 1.7, 1.7), 1e-12);
}

TEST(Waves, AJonswapRecordHasTheRequestedHeightAndPeak) {
  const Waves sea = Waves::jonswap(
      {.significant_height_m = 1.5, .peak_period_s = 6, .spreading_exponent = 4, .component_count = 128, .seed = 5},
      50);
  EXPECT_NEAR(sea.significant_height_m(), 1.5, 1e-12);
  constexpr int kSamples = 1 << 14;
  constexpr double kEvery_s = 0.5;
  std::vector<double> height(kSamples);
  double variance = 0;
  for (int k = 0; k < kSamples; ++k) {
    height[static_cast<std::size_t>(k)] = sea.height_at(1, 2, k * kEvery_s);
    variance += height[static_cast<std::size_t>(k)] * height[static_cast<std::size_t>(k)] / kSamples;
  }
  EXPECT_NEAR(4 * std::sqrt(variance), 1.5, 0.03 * 1.5);
  // Energy in bands of the record's Fourier lines.
  const double line = 2 * kPi / (kSamples * kEvery_s);
  const auto energy = [&](double low, double high) {
    double sum = 0;
    for (int m = static_cast<int>(low / line); m < static_cast<int>(high / line); ++m) {
      std::complex<double> c = 0, rotation = 1;
      const std::complex<double> step = std::polar(1.0, m * line * kEvery_s);
      for (const double h : height) {
        c += h * rotation;
        rotation *= step;
      }
      sum += std::norm(c);
    }
    return sum;
  };
  const double peak = 2 * kPi / 6;
  const double at_peak = energy(0.95 * peak, 1.05 * peak);
  EXPECT_GT(at_peak, energy(0.80 * peak, 0.90 * peak));
  EXPECT_GT(at_peak, energy(1.10 * peak, 1.20 * peak));
}

/// The autocorrelation of the surface at one position, over all times.
double correlation(const std::vector<WaveComponent>& waves, double lag_s) {
  double sum = 0, all = 0;
  for (const WaveComponent& w : waves) {
    sum += w.amplitude_m * w.amplitude_m * std::cos(w.angular_frequency_rad_s * lag_s);
    all += w.amplitude_m * w.amplitude_m;
  }
  return sum / all;
}

TEST(Waves, ASeaDoesNotRecurWithinTwoHours) {
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    const auto waves = Waves::jonswap({.peak_period_s = 8, .seed = seed}, 200).components();
    EXPECT_DOUBLE_EQ(correlation(waves, 0), 1);
    double most = 0;
    for (double lag = 150; lag < 7200; lag += 0.5) most = std::max(most, std::abs(correlation(waves, lag)));
    EXPECT_LT(most, 0.5) << seed;  // with evenly spaced frequencies, it is 1 after 205 s
  }
}

/// The ratio of second moment to energy of a sea's components [rad^2/s^2].
double mean_square_frequency(const Waves& sea) {
  double energy = 0, second = 0;
  for (const WaveComponent& w : sea.components()) {
    const double part = w.amplitude_m * w.amplitude_m;
    energy += part;
    second += part * w.angular_frequency_rad_s * w.angular_frequency_rad_s;
  }
  return second / energy;
}

TEST(Waves, APiersonMoskowitzSeaHasTheSecondMomentOfItsClosedForm) {
  // The moments of x^-5 exp(-1.25 x^-4) are 1.25^(n / 4 - 1) Gamma(1 - n / 4) / 4.
  const double expected = std::sqrt(kPi / 1.25) / 4 / 0.2 * std::pow(2 * kPi / 8, 2);
  for (const int count : {8, 64, 512}) {
    for (std::uint64_t seed = 0; seed < 5; ++seed) {
      const Waves sea =
          Waves::jonswap({.peak_period_s = 8, .peak_enhancement = 1, .component_count = count, .seed = seed}, kDeep);
      EXPECT_NEAR(mean_square_frequency(sea), expected, 0.01 * expected) << count;
      EXPECT_NEAR(sea.significant_height_m(), 0.5, 1e-12);
    }
  }
}

/// k^-3 dk/domega: a spectrum in frequency is proportional to this if that in wave number falls as k^-3.
double spectrum_of_wave_numbers(double omega_rad_s, double depth_m) {
  const double step = 1e-4 * omega_rad_s;
  const double low = wave_number_rad_m(omega_rad_s - step, depth_m, kGravity);
  const double high = wave_number_rad_m(omega_rad_s + step, depth_m, kGravity);
  return std::pow((low + high) / 2, -3) * (high - low) / (2 * step);
}

TEST(Waves, ASeaHasTheSecondMomentOfItsSpectrumAtAnyDepth) {
  for (const double gamma : {2.0, 3.3, 7.0}) {
    for (const double depth_m : {3.0, 10.0, 40.0, kDeep}) {
      double energy = 0, second = 0;
      for (double log_x = std::log(0.4); log_x < std::log(200); log_x += 0.002) {
        const double x = std::exp(log_x), omega = x * 2 * kPi / 8, sigma = x <= 1 ? 0.07 : 0.09, off = (x - 1) / sigma;
        const double part = spectrum_of_wave_numbers(omega, depth_m) * std::exp(-1.25 * std::pow(x, -4)) *
                            std::pow(gamma, std::exp(-off * off / 2)) * omega;
        energy += part;
        second += part * omega * omega;
      }
      const Waves sea = Waves::jonswap({.peak_period_s = 8, .peak_enhancement = gamma, .seed = 4}, depth_m);
      EXPECT_NEAR(mean_square_frequency(sea), second / energy, 0.01 * second / energy) << gamma << " " << depth_m;
    }
  }
}

TEST(Waves, ASeaHasTheEnergyOfWavespectraBelowEachFrequency) {
  struct Case {
    double depth_m, gamma;
    std::array<double, 6> below;
  };
  constexpr std::array<double, 6> kOfPeak = {0.9, 1, 1.1, 1.5, 2, 3};
  const Case cases[] = {
      // wavespectra 4.9.0: construct.frequency.jonswap and tma, peak period 8 s, integrated to 40 Hz
      {kDeep, 3.3, {0.1109, 0.3384, 0.5882, 0.8565, 0.9507, 0.9900}},
      {40, 7, {0.0679, 0.3432, 0.6755, 0.8938, 0.9635, 0.9926}},
      {10, 3.3, {0.0565, 0.2103, 0.4104, 0.7138, 0.8861, 0.9762}},
      {3, 3.3, {0.0492, 0.1834, 0.3588, 0.6307, 0.8049, 0.9386}},
  };
  for (const auto& [depth_m, gamma, expected] : cases) {
    const Waves sea = Waves::jonswap(
        {.significant_height_m = 0.1, .peak_period_s = 8, .peak_enhancement = gamma, .component_count = 512, .seed = 2},
        depth_m);
    for (std::size_t k = 0; k < kOfPeak.size(); ++k) {
      double below = 0, all = 0;
      for (const WaveComponent& wave : sea.components()) {
        const double energy = wave.amplitude_m * wave.amplitude_m;
        all += energy;
        if (wave.angular_frequency_rad_s < kOfPeak[k] * 2 * kPi / 8) below += energy;
      }
      EXPECT_NEAR(below / all, expected[k], 0.006) << depth_m << " m, " << kOfPeak[k] << " of the peak";
    }
  }
}

TEST(Waves, TheSteepestSeaOfFewWavesIsNotRefused) {
  const double highest_m = kGravity * 16 / (2 * kPi) / 15 - 1e-9;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    EXPECT_NO_THROW(Waves::jonswap(
        {.significant_height_m = highest_m, .peak_period_s = 4, .component_count = 8, .seed = seed}, 50));
  }
}

TEST(Waves, ASeaDependsOnItsSeed) {
  const JonswapSea sea{.seed = 1}, other{.seed = 2};
  EXPECT_EQ(Waves::jonswap(sea, 20).height_at(1, 2, 3), Waves::jonswap(sea, 20).height_at(1, 2, 3));
  EXPECT_NE(Waves::jonswap(sea, 20).height_at(1, 2, 3), Waves::jonswap(other, 20).height_at(1, 2, 3));
}

TEST(Waves, InvalidWavesAreRefused) {
  EXPECT_THROW(airy(-0.1, 4, 10), InvalidValue);
  EXPECT_THROW(airy(2, 2, 10), InvalidValue) << "it would break";
  const double k = wave_number_rad_m(2 * kPi / 2, kDeep, kGravity);
  EXPECT_NO_THROW(airy(0.4499 / k, 2, kDeep)) << "as steep as the message says";
  EXPECT_THROW(airy(0.4501 / k, 2, kDeep), InvalidValue);
  EXPECT_THROW(airy(0.4, 10, 0.5), InvalidValue) << "higher than the water is deep";
  EXPECT_THROW(Waves::jonswap({.peak_period_s = 0}, 10), InvalidValue);
  EXPECT_THROW(Waves::jonswap({.component_count = 1}, 10), InvalidValue);
  EXPECT_THROW(Waves::jonswap({.significant_height_m = 2, .peak_period_s = 3}, 50), InvalidValue) << "too steep";
}

}  // namespace
}  // namespace uwsim
