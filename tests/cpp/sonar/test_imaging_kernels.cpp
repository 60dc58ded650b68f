#include "uwsim/sonar/imaging/imaging_kernels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "uwsim/core/instruction_set.h"
#include "uwsim/core/lane_random.h"
#include "uwsim/core/random.h"
#include "uwsim/sonar/hashed_noise.h"

namespace uwsim {
namespace {

const RandomStream kRandom(5, "imaging kernels");

std::vector<const ImagingKernels*> all_kernels() {
  std::vector<const ImagingKernels*> all = {&baseline_imaging_kernels()};
  if (processor_has(InstructionSet::avx2)) all.push_back(&avx2_imaging_kernels());
  if (processor_has(InstructionSet::avx512)) all.push_back(&avx512_imaging_kernels());
  return all;
}

std::vector<double> uniform(std::size_t count, std::uint64_t tick) {
  std::vector<double> values;
  for (std::uint32_t k = 0; k < count; ++k) values.push_back(kRandom.uniform(tick, k));
  return values;
}

TEST(ImagingKernels, AReceivedLevelIsThatOfTheSameDrawsInDouble) {
  constexpr std::size_t kBins = 53;  // a tail after three blocks
  constexpr double kSource = 1e20, kNoise = 300;
  const std::vector<double> random = uniform(kBins, 1);
  for (const int looks : {0, 1, 3}) {
    std::vector<std::complex<float>> speckle;
    for (std::uint32_t k = 0; k < kBins * 3; ++k) {
      const auto [x, y] = kRandom.normals(2, k);
      speckle.emplace_back(static_cast<float>(x), static_cast<float>(y));
    }
    std::vector<double> echo;
    for (const double x : random) echo.push_back(std::pow(10.0, -30 + 25 * x));
    std::vector<float> gain_db, first_db;
    for (std::size_t k = 0; k < kBins; ++k) gain_db.push_back(static_cast<float>(0.7 * k));
    std::vector<double> first;
    for (const ImagingKernels* kernels : all_kernels()) {
      std::vector<double> power(kBins);
      std::vector<float> level_db(kBins);
      kernels->receive({kSource, kNoise, looks, kRandom.key(), 7, kRandom.stream(), 11, 5}, echo.data(),
                       reinterpret_cast<const float*>(speckle.data()), gain_db.data(), kBins, power.data(),
                       level_db.data());
      if (first.empty()) first = power, first_db = level_db;
      EXPECT_EQ(power, first);
      EXPECT_EQ(level_db, first_db);
    }
    for (std::size_t bin = 0; bin < kBins; ++bin) {
      double expected = looks == 0 ? kSource * echo[bin] + kNoise : 0;
      for (int look = 0; look < looks; ++look) {
        const bool shares = bin < 32 && bin >= 16;  // the words of the bin sixteen before
        const auto number =
            static_cast<std::uint64_t>((11 + 5 * static_cast<int>(shares ? bin - 16 : bin)) * looks + look);
        const PhiloxWords words = philox(7, 0, number, std::uint64_t{kRandom.stream()}, kRandom.key());
        const double radius = std::sqrt(-2 * std::log((words.word[shares][0] + 0.5) * 0x1p-32));
        const double angle = 2 * std::numbers::pi * (words.word[2 + shares][0] + 0.5) * 0x1p-32;
        const double x = radius * std::cos(angle), y = radius * std::sin(angle);
        const std::complex<double> scattered(
            speckle[bin * static_cast<std::size_t>(looks) + static_cast<std::size_t>(look)]);
        expected +=
            std::norm(std::sqrt(kSource * echo[bin]) * scattered + std::sqrt(kNoise / 2) * std::complex<double>(x, y)) /
            looks;
      }
      EXPECT_NEAR(first[bin], expected, 1e-5 * (expected + kNoise)) << bin;
      EXPECT_NEAR(first_db[bin], 10 * std::log10(first[bin]) + gain_db[bin], 5e-5) << bin;
    }
  }
}

TEST(ImagingKernels, BeamsAreWeightedSumsOfTheirRows) {
  constexpr std::size_t kCount = 7, kStep = 2, kBins = 77, kBeams = 3, kBlocks = 2;
  constexpr std::size_t kRows = kCount + (kBeams - 1) * kStep;
  const std::vector<double> rows = uniform(kRows * kBins, 3), each = uniform(kCount, 4);
  const std::vector<float> weights(each.begin(), each.end());
  std::vector<float> padded(3 * kStep, 0.0f);
  padded.insert(padded.end(), weights.begin(), weights.end());
  padded.resize(padded.size() + 3 * kStep, 0.0f);
  for (const ImagingKernels* kernels : all_kernels()) {
    std::vector<float> blocks(kBlocks * kRows * kBlockBins, -1.0f);
    for (std::size_t row = 0; row < kRows; ++row) {
      kernels->store_row(rows.data() + row * kBins, kBins, kRows, blocks.data() + row * kBlockBins);
    }
    std::vector<double> sums(4 * kBlocks * kBlockBins);
    kernels->sum_beams({blocks.data(), kRows, kBlocks}, padded.data(), kCount, kStep, kBeams, sums.data());
    for (std::size_t beam = 0; beam < kBeams; ++beam) {
      for (std::size_t bin = 0; bin < kBlocks * kBlockBins; ++bin) {
        float expected = 0;
        for (std::size_t k = 0; k < kCount && bin < kBins; ++k) {
          expected += weights[k] * static_cast<float>(rows[(beam * kStep + k) * kBins + bin]);
        }
        EXPECT_EQ(sums[beam * kBlocks * kBlockBins + bin], double{expected});
      }
    }
  }
}

TEST(ImagingKernels, NoisesAndRowsAreSummedInOrder) {
  constexpr std::size_t kCells = 37, kTerms = 3;  // a tail after two blocks
  const std::array<std::uint32_t, kTerms> keys = {1, 4000000000u, 77};
  const std::array<float, kTerms> weights = {0.5f, -2, 0.3f};
  std::vector<float> noises, sum(2 * kCells);
  for (const std::uint32_t key : keys) {
    for (std::uint32_t cell = 0; cell < kCells; ++cell) {
      const auto [one, two] = byte_sums(mixed(key + cell));
      noises.insert(noises.end(), {one, two});
    }
  }
  for (std::size_t term = 0; term < kTerms; ++term) {
    for (std::size_t k = 0; k < 2 * kCells; ++k) sum[k] += weights[term] * noises[term * 2 * kCells + k];
  }
  for (const ImagingKernels* kernels : all_kernels()) {
    std::vector<float> row(2 * kCells), rows(2 * kCells);
    kernels->noise(keys.data(), weights.data(), kTerms, kCells, row.data());
    kernels->sum_rows(noises.data(), weights.data(), kTerms, 2 * kCells, rows.data());
    EXPECT_EQ(row, sum);
    EXPECT_EQ(rows, sum);
  }
}

TEST(ImagingKernels, AnEchoIsSpreadEvenlyOverItsInterval) {
  constexpr std::size_t kBins = 41;  // echoes end within and beyond the last whole block of eight bins
  const std::vector<double> random = uniform(48, 6);
  double power[16], near_bin[16], far_bin[16];
  for (std::size_t k = 0; k < 16; ++k) {
    power[k] = k == 7 ? 0 : 1 + random[k];
    near_bin[k] = (k == 3 ? 30 : 45) * random[16 + k];
    far_bin[k] = near_bin[k] + (k == 3 ? 0 : 20 * random[32 + k] * random[32 + k]);
  }
  std::vector<double> expected(kBins, 0.0), first;
  for (std::size_t k = 0; k < 16; ++k) {
    const double length = far_bin[k] - near_bin[k];
    for (std::size_t bin = 0; bin < kBins; ++bin) {
      const auto low = static_cast<double>(bin);
      const double covered = std::min(low + 1, far_bin[k]) - std::max(low, near_bin[k]);
      const bool inside = near_bin[k] >= low && near_bin[k] < low + 1;
      expected[bin] += power[k] * (length > 0 ? std::max(covered, 0.0) / length : inside ? 1.0 : 0.0);
    }
  }
  for (const ImagingKernels* kernels : all_kernels()) {
    std::vector<double> profile(kBins, 0.0);
    kernels->spread(power, near_bin, far_bin, 16, kBins, profile.data());
    for (std::size_t bin = 0; bin < kBins; ++bin) EXPECT_NEAR(profile[bin], expected[bin], 1e-12) << bin;
    if (first.empty()) first = profile;
    EXPECT_EQ(profile, first);
  }
}

TEST(ImagingKernels, APatchOnAPlaneLiesBetweenTheRangesAtItsEnds) {
  ArcFrames arc{};
  for (int k = 0; k < 16; ++k) arc.ahead[0][k] = arc.up[2][k] = arc.cos_aside[k] = 1, arc.aside[1][k] = -1;
  constexpr float kDepth_m = 4, kHalf_rad = 2e-3f;
  float angle[16], cosine[16], sine[16], lower_cosine[16], lower_sine[16], upper_cosine[16], upper_sine[16];
  float distance[16], x[16] = {}, y[16] = {}, z[16];
  for (int k = 0; k < 16; ++k) {
    angle[k] = -0.3f - 0.07f * static_cast<float>(k);
    cosine[k] = std::cos(angle[k]), sine[k] = std::sin(angle[k]);
    lower_cosine[k] = std::cos(angle[k] - kHalf_rad), lower_sine[k] = std::sin(angle[k] - kHalf_rad);
    upper_cosine[k] = std::cos(angle[k] + kHalf_rad), upper_sine[k] = std::sin(angle[k] + kHalf_rad);
    distance[k] = -kDepth_m / sine[k];
    z[k] = k % 2 == 0 ? 3.0f : -1.0f;  // every other one is hit from inside
  }
  const ArcAngles angles{cosine, sine, lower_cosine, lower_sine, upper_cosine, upper_sine};
  std::vector<float> first;
  for (const ImagingKernels* kernels : all_kernels()) {
    float near_bin[16], far_bin[16], facing[16], loss[16];
    kernels->patches(arc, angles, {distance, x, y, z}, {-10, 0.1f, 0.5f}, {near_bin, far_bin, facing, loss});
    std::vector<float> all;
    for (int k = 0; k < 16; ++k) {
      all.insert(all.end(), {facing[k], loss[k]});
      if (k % 2 == 1) {
        EXPECT_LE(facing[k], 0);
        continue;
      }
      all.insert(all.end(), {near_bin[k], far_bin[k]});
      EXPECT_NEAR(facing[k], -sine[k], 1e-6);
      EXPECT_NEAR(near_bin[k], -kDepth_m / lower_sine[k] / 0.5f, 1e-4 * near_bin[k]);
      EXPECT_NEAR(far_bin[k], -kDepth_m / upper_sine[k] / 0.5f, 1e-4 * far_bin[k]);
      EXPECT_NEAR(loss[k], std::pow(10.0, -0.2 * 0.1 * distance[k]) / (distance[k] * distance[k]), 2e-6 * loss[k]);
    }
    if (first.empty()) first = all;
    EXPECT_EQ(all, first);
  }
}

}  // namespace
}  // namespace uwsim
