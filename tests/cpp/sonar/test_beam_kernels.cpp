#include "uwsim/core/instruction_set.h"
#include "uwsim/sonar/beam_kernels.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "uwsim/core/random.h"
#include "uwsim/sonar/hashed_noise.h"

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

std::vector<const BeamKernels*> all_kernels() {
  std::vector<const BeamKernels*> all = {&baseline_beam_kernels()};
  if (processor_has(InstructionSet::avx2)) all.push_back(&avx2_beam_kernels());
  if (processor_has(InstructionSet::avx512)) all.push_back(&avx512_beam_kernels());
  return all;
}

TEST(BeamKernels, NoiseIsTheWeightedSumOverPairsOfCells) {
  const std::array<std::uint32_t, 4> rows = {1, 900, 77, 4000000000u}, columns = {5, 6, 123456, 3},
                                     fields = {9, 8, 7, 6};
  const std::array<float, 4> row_weights = {0.1f, 0.7f, -0.3f, 0.5f}, column_weights = {1, 0.25f, 0.5f, -2};
  for (const BeamKernels* kernels : all_kernels()) {
    std::array<float, 4> one, two;
    kernels->noise({rows.data(), row_weights.data(), columns.data(), column_weights.data(), fields.data()}, one.data(),
                   two.data());
    for (std::size_t field = 0; field < 4; ++field) {
      double first = 0, second = 0;
      for (std::size_t i = 0; i < 4; ++i) {
        for (std::size_t j = 0; j < 4; ++j) {
          const auto [a, b] = byte_sums(mixed(rows[i] + columns[j] + fields[field]));
          first += double{row_weights[i]} * column_weights[j] * a;
          second += double{row_weights[i]} * column_weights[j] * b;
        }
      }
      EXPECT_NEAR(one[field], first, 1e-3);
      EXPECT_NEAR(two[field], second, 1e-3);
    }
  }
}

TEST(BeamKernels, AWaterColumnIsEchoesWaterAndNoiseTimesExponentialSpeckle) {
  const RandomStream random(5, "column");
  for (std::uint64_t tick = 0; tick < 300; ++tick) {
    const auto uniform = [&](std::uint32_t k) { return static_cast<float>(random.uniform(tick, k)); };
    Lanes<float> echoes{};
    for (std::uint32_t k = 0; k < 16; k += 5) echoes[k] = std::pow(10.0f, -14 * uniform(k));
    ColumnSamples in{};
    in.echoes = echoes.data(), in.noise = 1 + uniform(20), in.system_ratio = std::pow(10.0f, 12 * uniform(21));
    in.step_m = 0.01f + 0.2f * uniform(22), in.first_m = (static_cast<float>(tick) + 0.5f) * in.step_m;
    in.water_m = in.first_m + 20 * in.step_m * uniform(23), in.volume = std::pow(10.0f, -10 * uniform(24));
    in.lost = uniform(25), in.rate = -0.04f * uniform(26), in.level_db = -100 * uniform(27);
    in.key = 7 * static_cast<std::uint32_t>(tick), in.second_key = 99, in.index = 3, in.cells = 1 + tick % 3;
    Lanes<float> first;
    baseline_beam_kernels().column(in, first.data());
    for (std::uint32_t k = 0; k < 16; ++k) {
      const float range = in.first_m + static_cast<float>(k) * in.step_m;
      const double water = range < in.water_m ? in.volume * in.lost * std::exp(in.rate * (k - 7.5)) / range / range : 0;
      double speckle = 0;
      for (std::uint32_t cell = 0; cell < in.cells; ++cell) {
        const std::uint32_t hash = mixed(mixed(in.key + (in.index + k) * in.cells + cell) ^ in.second_key);
        speckle -= std::log((std::floor(hash / 512.0) + 0.5) / 8388608);
      }
      const double level = 10 * std::log10((in.system_ratio * (echoes[k] + water) + in.noise) * speckle / in.cells);
      EXPECT_NEAR(first[k], level + in.level_db, 1e-4);
    }
    for (const BeamKernels* kernels : all_kernels()) {
      Lanes<float> level;
      kernels->column(in, level.data());
      EXPECT_EQ(level, first);
    }
  }
}

TEST(BeamKernels, APatchExtendsByItsTangentAndItsReliefAndFadesWithTheSquareOfRange) {
  Lanes<float> x, y, z, length, cosine, gain, lost, spacing, relief, energy, width, point;
  const RandomStream random(5, "patches");
  const auto uniform = [&](std::uint32_t k, std::uint32_t row) { return static_cast<float>(random.uniform(row, k)); };
  for (std::uint32_t k = 0; k < 16; ++k) {
    x[k] = uniform(k, 1), y[k] = uniform(k, 2), z[k] = 0.1f + uniform(k, 3);
    length[k] = 1 + 90 * uniform(k, 4), gain[k] = uniform(k, 5), lost[k] = uniform(k, 6);
    spacing[k] = 0.01f * uniform(k, 7), relief[k] = uniform(k, 8);
  }
  const Lanes<float> none{}, down = [] {
    Lanes<float> all;
    return all.fill(-1), all;
  }();
  std::vector<float> first;
  for (const BeamKernels* kernels : all_kernels()) {
    kernels->incidence({x.data(), y.data(), z.data(), none.data(), none.data(), down.data()}, cosine.data());
    kernels->patches({length.data(), cosine.data(), gain.data(), lost.data(), spacing.data(), relief.data(), 0.05f},
                     {energy.data(), width.data(), point.data()});
    std::vector<float> all;
    for (std::size_t k = 0; k < 16; ++k) {
      const double incidence =
          std::acos(z[k] / std::sqrt(double{x[k]} * x[k] + double{y[k]} * y[k] + double{z[k]} * z[k]));
      const double height_m = relief[k] * std::cos(incidence), patch_m = length[k] * spacing[k] * std::tan(incidence);
      EXPECT_NEAR(cosine[k], std::cos(incidence), 1e-6);
      EXPECT_NEAR(point[k], 0.05 * 0.05 + height_m * height_m, 1e-5);
      EXPECT_NEAR(width[k], std::sqrt(0.05 * 0.05 + height_m * height_m + patch_m * patch_m), 1e-5);
      EXPECT_NEAR(energy[k] * length[k] * length[k], gain[k] * lost[k], 1e-6);
      all.insert(all.end(), {cosine[k], point[k], width[k], energy[k]});
    }
    if (first.empty()) first = all;
    EXPECT_EQ(all, first);
  }
}

}  // namespace
}  // namespace uwsim
