#include "uwsim/world/wave_sums.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstring>
#include <utility>
#include <vector>

#include "uwsim/core/instruction_set.h"
#include "uwsim/core/random.h"

namespace uwsim {
namespace {

constexpr double kDepth_m = 12, kGravity_m_s2 = 9.81;

struct Wave {
  double amplitude, omega, number, x, y, phase, deep;
};

std::vector<Wave> random_waves(std::size_t count) {
  const RandomStream random(3, "waves");
  std::vector<Wave> waves;
  for (std::size_t k = 0; k < count; ++k) {
    const auto draw = [&](std::uint32_t n) { return random.uniform(k, n); };
    const double omega = 0.6 + 3 * draw(0), number = omega * omega / kGravity_m_s2, heading = 6 * draw(1);
    waves.push_back({0.1 * draw(2), omega, number, number * std::cos(heading), number * std::sin(heading), 6 * draw(3),
                     1 / (1 + std::exp(-2 * number * kDepth_m))});
  }
  return waves;
}

std::vector<WaveBlock> in_blocks(const std::vector<Wave>& waves) {
  std::vector<WaveBlock> blocks((waves.size() + 7) / 8);
  for (std::size_t k = 0; k < waves.size(); ++k) {
    const Wave& w = waves[k];
    WaveBlock& b = blocks[k / 8];
    b.amplitude_m[k % 8] = w.amplitude;
    b.omega_rad_s[k % 8] = w.omega;
    b.period_s_rad[k % 8] = 1 / w.omega;
    b.number_rad_m[k % 8] = w.number;
    b.number_x_rad_m[k % 8] = w.x;
    b.number_y_rad_m[k % 8] = w.y;
    b.phase_rad[k % 8] = w.phase;
    b.deep[k % 8] = w.deep;
    b.rise_rad_s[k % 8] = w.omega / std::tanh(w.number * kDepth_m);
    b.along_m_s[k % 8] = b.rise_rad_s[k % 8] / w.number;
    b.mirror[k % 8] = w.deep * std::exp(-2 * w.number * kDepth_m);
  }
  return blocks;
}

struct Sums {
  std::array<CrestBlock, 9> crests;
  double height_m;
  WaveMotionSums motion, motion_too;
  WaveSurfaceSums surface;
  WaveIntegrals over, over_too, load;

  double cosine(std::size_t k) const { return crests[k / 8].cosine_m[k % 8]; }
  double sine(std::size_t k) const { return crests[k / 8].sine_m[k % 8]; }
};

constexpr WavesOnVolume kVolume = {-1.5, 1, 0.02, {{3e-4, 1e-5, 2e-5}, {1e-5, 5e-4, 4e-5}, {2e-5, 4e-5, 2e-4}}};
constexpr std::array kSpread_m2 = {0.05, 0.01, 0.03};

Sums sums_by(const WaveSumKernels& kernels, const std::vector<Wave>& waves, double time_s) {
  Sums sums;
  std::memset(&sums, 0, sizeof sums);
  const std::vector<WaveBlock> blocks = in_blocks(waves);
  EXPECT_TRUE(kernels.crests(blocks.data(), blocks.size(), 3.1, -7.7, time_s, sums.crests.data(), sums.height_m));
  kernels.motion(blocks.data(), blocks.size(), sums.crests.data(), kVolume.z_m, sums.motion);
  kernels.surface(blocks.data(), blocks.size(), sums.crests.data(), kSpread_m2.data(), sums.surface);
  kernels.over(blocks.data(), blocks.size(), sums.crests.data(), kVolume, sums.over);
  kernels.over_with_motion(blocks.data(), blocks.size(), sums.crests.data(), kVolume, sums.over_too, sums.motion_too);
  kernels.load(blocks.data(), blocks.size(), sums.crests.data(), kVolume, sums.load);
  return sums;
}

TEST(WaveSums, AreTheSameToTheLastBitWithEveryInstructionSet) {
  for (const std::size_t count : {1, 7, 8, 64}) {
    const std::vector<Wave> waves = random_waves(count);
    const Sums baseline = sums_by(baseline_wave_sum_kernels(), waves, 1234.5);
    for (const auto& [set, kernels] : {std::pair{InstructionSet::avx2, &avx2_wave_sum_kernels()},
                                       std::pair{InstructionSet::avx512, &avx512_wave_sum_kernels()}}) {
      if (!processor_has(set)) continue;
      const Sums wide = sums_by(*kernels, waves, 1234.5);
      EXPECT_EQ(std::memcmp(&wide, &baseline, sizeof wide), 0) << count;
    }
  }
}

TEST(WaveSums, CrestsAreSinesAndCosinesToRounding) {
  for (const double time_s : {0.0, 1.0, 1e3, 2e5}) {
    const std::vector<Wave> waves = random_waves(61);
    const Sums sums = sums_by(wave_sum_kernels(), waves, time_s);
    double height = 0;
    for (std::size_t k = 0; k < 61; ++k) {
      const Wave& w = waves[k];
      const double phase = w.x * 3.1 + w.y * -7.7 - w.omega * time_s + w.phase;
      EXPECT_NEAR(sums.cosine(k), w.amplitude * std::cos(phase), 3e-16 * w.amplitude);
      EXPECT_NEAR(sums.sine(k), w.amplitude * std::sin(phase), 3e-16 * w.amplitude);
      height += w.amplitude * std::cos(phase);
    }
    EXPECT_NEAR(sums.height_m, height, 1e-14);
  }
  CrestBlock crests;
  double height = 0;
  EXPECT_FALSE(wave_sum_kernels().crests(in_blocks(random_waves(8)).data(), 1, 0, 0, 1e7, &crests, height));
}

// The potential of each wave is the real part of -i (g / omega) (cos + i sin) cosh(k (z + h)) / cosh(k h).
TEST(WaveSums, VelocityAndItsGradientAreThoseOfLinearTheory) {
  const std::vector<Wave> waves = random_waves(40);
  const Sums sums = sums_by(wave_sum_kernels(), waves, 17.25);
  double u[3] = {}, xz = 0, accelerates_up = 0;
  for (std::size_t k = 0; k < 40; ++k) {
    const Wave& w = waves[k];
    const double number = w.number, over_bed = number * (kVolume.z_m + kDepth_m), c = sums.cosine(k), s = sums.sine(k);
    const double along = w.omega * std::cosh(over_bed) / std::sinh(number * kDepth_m) / number;
    const double rise = w.omega * std::sinh(over_bed) / std::sinh(number * kDepth_m);
    u[0] += along * c * w.x;
    u[1] += along * c * w.y;
    u[2] += rise * s;
    xz += rise * c * w.x;
    accelerates_up -= w.omega * rise * c;
  }
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(sums.motion.velocity_m_s[k], u[k], 1e-14);
  EXPECT_NEAR(sums.motion.gradient[3], xz, 1e-14);
  EXPECT_EQ(std::memcmp(&sums.motion, &sums.motion_too, offsetof(WaveMotionSums, local_m_s2)), 0);
  EXPECT_NEAR(sums.motion.local_m_s2[2], accelerates_up, 1e-14);
}

// See Waves::add_flow_over for the integrals. The velocity's potential is i / omega times the head.
TEST(WaveSums, VelocityAndItsRateAreIntegratedOverTheVolume) {
  using Complex = std::complex<double>;
  const std::vector<Wave> waves = random_waves(40);
  const Sums sums = sums_by(wave_sum_kernels(), waves, 17.25);
  Complex velocity[3] = {}, turning[3] = {}, rate[3] = {}, turning_rate[3] = {};
  for (std::size_t k = 0; k < 40; ++k) {
    const Wave& w = waves[k];
    for (const double sign : {1.0, -1.0}) {
      if (sign < 0 && w.deep == 1) continue;
      const double decay = std::exp(sign > 0 ? w.number * kVolume.z_m : -w.number * (kVolume.z_m + 2 * kDepth_m));
      const Complex eta = w.deep * decay * Complex(sums.cosine(k), sums.sine(k));
      const Complex kappa[3] = {{0, w.x}, {0, w.y}, sign * w.number};
      Complex turned[3] = {}, x = 0;
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) turned[i] += kVolume.second_m5[i][j] * kappa[j];
        x += kappa[i] * turned[i] / (2 * kVolume.volume_m3);
      }
      for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, l = (i + 2) % 3;
        const Complex along = -eta * kappa[i] * kVolume.volume_m3 * (1.0 + x + x * x / 3.0);
        const Complex about = -eta * (turned[j] * kappa[l] - turned[l] * kappa[j]) * (1.0 + 0.65 * x);
        rate[i] += along;
        turning_rate[i] += about;
        velocity[i] += Complex(0, 1 / w.omega) * along;
        turning[i] += Complex(0, 1 / w.omega) * about;
      }
    }
  }
  EXPECT_EQ(std::memcmp(&sums.over, &sums.over_too, sizeof sums.over), 0);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(sums.load.rate[i], sums.over.rate[i]) << i;
    EXPECT_EQ(sums.load.turning_rate[i], sums.over.turning_rate[i]) << i;
    EXPECT_NEAR(sums.over.rate[i], rate[i].real(), 1e-15) << i;
    EXPECT_NEAR(sums.over.turning_rate[i], turning_rate[i].real(), 1e-17) << i;
    EXPECT_NEAR(sums.over.velocity[i], velocity[i].real(), 1e-15) << i;
    EXPECT_NEAR(sums.over.turning[i], turning[i].real(), 1e-17) << i;
  }
}

/// A rectangle of this spread, sampled: the mean of the surface, and its slopes by least squares.
TEST(WaveSums, TheSurfaceIsAveragedOverTheArea) {
  const std::vector<Wave> waves = random_waves(40);
  constexpr double kX_m2 = 0.08, kY_m2 = 0.02;
  const double half_x = std::sqrt(3 * kX_m2), half_y = std::sqrt(3 * kY_m2);
  const std::vector<WaveBlock> blocks = in_blocks(waves);
  const std::array<double, 3> spread_m2 = {kX_m2, 0, kY_m2};
  const auto crests_at = [&](double x, double y, std::array<CrestBlock, 5>& crests) {
    double height = 0;
    wave_sum_kernels().crests(blocks.data(), blocks.size(), x, y, 17.25, crests.data(), height);
    return height;
  };
  std::array<CrestBlock, 5> crests;
  WaveSurfaceSums got;
  crests_at(3.1, -7.7, crests);
  wave_sum_kernels().surface(blocks.data(), blocks.size(), crests.data(), spread_m2.data(), got);
  constexpr int kCells = 60;
  double mean = 0, slope_x = 0, slope_y = 0;
  for (int n = 0; n < kCells * kCells; ++n) {
    const double x = half_x * (2 * (n % kCells + 0.5) / kCells - 1), y = half_y * (2 * (n / kCells + 0.5) / kCells - 1);
    std::array<CrestBlock, 5> unused;
    const double height = crests_at(3.1 + x, -7.7 + y, unused) / (kCells * kCells);
    mean += height;
    slope_x += x * height / kX_m2;
    slope_y += y * height / kY_m2;
  }
  EXPECT_NEAR(got.mean_m, mean, 0.005 * std::abs(mean));
  EXPECT_NEAR(got.slope_x, slope_x, 0.005 * std::hypot(slope_x, slope_y));
  EXPECT_NEAR(got.slope_y, slope_y, 0.005 * std::hypot(slope_x, slope_y));
}

}  // namespace
}  // namespace uwsim
