#include "uwsim/core/instruction_set.h"
#include "uwsim/sonar/beam_kernels.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "uwsim/core/random.h"

namespace uwsim {
namespace {

template <typename T>
using Lanes = std::array<T, 16>;

struct Beams {
  Lanes<double> distance, nx, ny, nz, dx, dy, dz;
  Lanes<std::uint32_t> label;
  Lanes<float> strength, range, incidence, intensity;
  Lanes<std::uint16_t> out_label;
  Lanes<std::uint8_t> valid;

  /// Hits straight below a deep head at various distances and incidences.
  explicit Beams(std::uint64_t tick) {
    const RandomStream random(5, "beams");
    for (std::uint32_t k = 0; k < 16; ++k) {
      distance[k] = std::pow(10.0, -1.5 + 4.5 * random.uniform(tick, 4 * k));
      const double turn = random.uniform(tick, 4 * k + 1) * std::numbers::pi / 2;
      nx[k] = std::sin(turn);
      ny[k] = 0;
      nz[k] = std::cos(turn);
      dx[k] = dy[k] = 0;
      dz[k] = random.uniform(tick, 4 * k + 2) < 0.9 ? -1 : 1;
      label[k] = 1 + k;
      strength[k] = -20 - static_cast<float>(k);
    }
  }

  void run(const BeamKernels& kernels, const EchoRule& rule) {
    kernels.echoes({distance.data(), nx.data(), ny.data(), nz.data(), dx.data(), dy.data(), dz.data(), label.data(),
                    strength.data()},
                   rule, {range.data(), incidence.data(), intensity.data(), out_label.data(), valid.data()});
  }
};

constexpr EchoRule kRule{-100, 600, 0.07};

TEST(BeamKernels, AnEchoFollowsTheSonarEquationWithinAMillionth) {
  for (std::uint64_t tick = 0; tick < 500; ++tick) {
    Beams beams(tick);
    beams.run(beam_kernels(), kRule);
    for (std::size_t k = 0; k < 16; ++k) {
      const bool echo = beams.distance[k] < 600 && -100 + beams.distance[k] * beams.dz[k] <= 0;
      ASSERT_EQ(beams.valid[k], echo ? 1 : 0);
      EXPECT_EQ(beams.out_label[k], echo ? 1 + k : 0);
      if (!echo) {
        EXPECT_TRUE(std::isinf(beams.range[k]) && std::isnan(beams.incidence[k]) && std::isinf(beams.intensity[k]));
        continue;
      }
      EXPECT_EQ(beams.range[k], static_cast<float>(beams.distance[k]));
      EXPECT_NEAR(beams.incidence[k], std::acos(std::abs(beams.nz[k] * beams.dz[k])), 1e-6);
      const double level = -40 * std::log10(beams.distance[k]) - 2 * 0.07 * beams.distance[k] + beams.strength[k] +
                           20 * std::log10(beams.nz[k]);
      EXPECT_NEAR(beams.intensity[k], level, 2e-6 * std::abs(level) + 1e-5);
    }
  }
}

TEST(BeamKernels, AllInstructionSetsGiveTheSameBits) {
  for (std::uint64_t tick = 0; tick < 200; ++tick) {
    Beams one(tick), two(tick), three(tick);
    one.run(baseline_beam_kernels(), kRule);
    const auto expect_same = [&](Beams& other, const BeamKernels& kernels) {
      other.run(kernels, kRule);
      for (std::size_t k = 0; k < 16; ++k) {
        ASSERT_EQ(one.valid[k], other.valid[k]);
        if (one.valid[k] == 0) continue;
        EXPECT_EQ(one.incidence[k], other.incidence[k]);
        EXPECT_EQ(one.intensity[k], other.intensity[k]);
      }
    };
    if (processor_has(InstructionSet::avx2)) expect_same(two, avx2_beam_kernels());
    if (processor_has(InstructionSet::avx512)) expect_same(three, avx512_beam_kernels());
  }
}

TEST(BeamKernels, RisingRaysEndAtTheSurface) {
  Lanes<double> direction_z, reach;
  for (std::size_t k = 0; k < 16; ++k) direction_z[k] = (static_cast<double>(k) - 8) / 8;
  beam_kernels().reach(-5, 40, direction_z.data(), reach.data());
  for (std::size_t k = 0; k < 16; ++k)
    EXPECT_EQ(reach[k], direction_z[k] > 0 ? std::min(40.0, 5 / direction_z[k]) : 40);
}

}  // namespace
}  // namespace uwsim
