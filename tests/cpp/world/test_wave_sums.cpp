#include "uwsim/world/wave_sums.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <complex>
#include <cstring>
#include <utility>
#include <vector>

#include "uwsim/core/instruction_set.h"
#include "uwsim/core/random.h"

namespace uwsim {
namespace {

constexpr double kDepth_m = 12, kGravity_m_s2 = 9.81;

/// Rows of amplitude, frequency, wave number, its x and y components, phase, deep, shallow.
std::vector<double> random_waves(std::size_t count) {
  const RandomStream random(3, "waves");
  std::vector<double> rows;
  for (std::size_t k = 0; k < count; ++k) {
    const auto draw = [&](std::uint32_t n) { return random.uniform(k, n); };
    const double omega = 0.6 + 3 * draw(0), number = omega * omega / kGravity_m_s2, heading = 6 * draw(1);
    rows.insert(rows.end(),
                {0.1 * draw(2), omega, number, number * std::cos(heading), number * std::sin(heading), 6 * draw(3),
                 1 / (1 + std::exp(-2 * number * kDepth_m)), 1 / std::tanh(number * kDepth_m)});
  }
  return rows;
}

struct Sums {
  std::array<double, 2 * 72> crests;
  double height_m;
  WaveMotionSums motion;
  WaveIntegrals over;
};

constexpr WavesOnVolume kVolume = {-1.5, kDepth_m, 0.02, {{3e-4, 1e-5, 2e-5}, {1e-5, 5e-4, 4e-5}, {2e-5, 4e-5, 2e-4}}};

Sums sums_by(const WaveSumKernels& kernels, const std::vector<double>& waves, double time_s) {
  Sums sums;
  std::memset(&sums, 0, sizeof sums);
  const std::size_t count = waves.size() / WaveSumKernels::kNumbers;
  EXPECT_TRUE(kernels.crests(waves.data(), count, 3.1, -7.7, time_s, sums.crests.data(), sums.height_m));
  kernels.motion(waves.data(), count, sums.crests.data(), kVolume.z_m, kDepth_m, sums.motion);
  kernels.over(waves.data(), count, sums.crests.data(), kVolume, sums.over);
  return sums;
}

TEST(WaveSums, AreTheSameToTheLastBitWithEveryInstructionSet) {
  for (const std::size_t count : {1, 7, 8, 64}) {
    const std::vector<double> waves = random_waves(count);
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
    const std::vector<double> waves = random_waves(61);
    const Sums sums = sums_by(wave_sum_kernels(), waves, time_s);
    double height = 0;
    for (std::size_t k = 0; k < 61; ++k) {
      const double* w = &waves[WaveSumKernels::kNumbers * k];
      const double phase = w[3] * 3.1 + w[4] * -7.7 - w[1] * time_s + w[5];
      EXPECT_NEAR(sums.crests[2 * k], w[0] * std::cos(phase), 3e-16 * w[0]);
      EXPECT_NEAR(sums.crests[2 * k + 1], w[0] * std::sin(phase), 3e-16 * w[0]);
      height += w[0] * std::cos(phase);
    }
    EXPECT_NEAR(sums.height_m, height, 1e-14);
  }
  std::array<double, 16> crests;
  double height = 0;
  EXPECT_FALSE(wave_sum_kernels().crests(random_waves(8).data(), 8, 0, 0, 1e7, crests.data(), height));
}

// The potential of each wave is the real part of -i (g / omega) (cos + i sin) cosh(k (z + h)) / cosh(k h).
TEST(WaveSums, VelocityAndItsGradientAreThoseOfLinearTheory) {
  const std::vector<double> waves = random_waves(40);
  const Sums sums = sums_by(wave_sum_kernels(), waves, 17.25);
  double u[3] = {}, xz = 0, accelerates_up = 0;
  for (std::size_t k = 0; k < 40; ++k) {
    const double* w = &waves[WaveSumKernels::kNumbers * k];
    const double number = w[2], over_bed = number * (kVolume.z_m + kDepth_m), c = sums.crests[2 * k],
                 s = sums.crests[2 * k + 1];
    const double along = w[1] * std::cosh(over_bed) / std::sinh(number * kDepth_m) / number;
    const double rise = w[1] * std::sinh(over_bed) / std::sinh(number * kDepth_m);
    u[0] += along * c * w[3];
    u[1] += along * c * w[4];
    u[2] += rise * s;
    xz += rise * c * w[3];
    accelerates_up -= w[1] * rise * c;
  }
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(sums.motion.velocity_m_s[k], u[k], 1e-14);
  EXPECT_NEAR(sums.motion.gradient[3], xz, 1e-14);
  EXPECT_NEAR(sums.motion.local_m_s2[2], accelerates_up, 1e-14);
}

// See Waves::add_flow_over for the integrals. The velocity's potential is i / omega times the head.
TEST(WaveSums, VelocityAndItsRateAreIntegratedOverTheVolume) {
  using Complex = std::complex<double>;
  const std::vector<double> waves = random_waves(40);
  const Sums sums = sums_by(wave_sum_kernels(), waves, 17.25);
  Complex velocity[3] = {}, turning[3] = {}, rate[3] = {}, turning_rate[3] = {};
  for (std::size_t k = 0; k < 40; ++k) {
    const double* w = &waves[WaveSumKernels::kNumbers * k];
    for (const double sign : {1.0, -1.0}) {
      if (sign < 0 && w[6] == 1) continue;
      const double decay = std::exp(sign > 0 ? w[2] * kVolume.z_m : -w[2] * (kVolume.z_m + 2 * kDepth_m));
      const Complex eta = w[6] * decay * Complex(sums.crests[2 * k], sums.crests[2 * k + 1]);
      const Complex kappa[3] = {{0, w[3]}, {0, w[4]}, sign * w[2]};
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
        velocity[i] += Complex(0, 1 / w[1]) * along;
        turning[i] += Complex(0, 1 / w[1]) * about;
      }
    }
  }
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(sums.over.rate[i], rate[i].real(), 1e-15) << i;
    EXPECT_NEAR(sums.over.turning_rate[i], turning_rate[i].real(), 1e-17) << i;
    EXPECT_NEAR(sums.over.velocity[i], velocity[i].real(), 1e-15) << i;
    EXPECT_NEAR(sums.over.turning[i], turning[i].real(), 1e-17) << i;
  }
}

}  // namespace
}  // namespace uwsim
