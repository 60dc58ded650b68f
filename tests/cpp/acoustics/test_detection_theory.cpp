#include "uwsim/acoustics/detection_theory.h"

#include <gtest/gtest.h>

#include <cmath>

#include "uwsim/core/random.h"

namespace uwsim {
namespace {

constexpr int kDraws = 200'000;

struct Moments {
  double mean, variance;
};

template <typename Value>
Moments moments(Value value) {
  const RandomStream stream(3, "fading");
  double sum = 0, squares = 0;
  for (int k = 0; k < kDraws; ++k) {
    const auto [first, second] = stream.normals(static_cast<std::uint64_t>(k));
    const double drawn = value(first, second);
    sum += drawn;
    squares += drawn * drawn;
  }
  const double mean = sum / kDraws;
  return {mean, squares / kDraws - mean * mean};
}

TEST(DetectionTheory, SpeckleIsTheMeanOfItsLooks) {
  for (const double looks : {1.0, 4.0, 20.0}) {
    const auto [mean, variance] = moments([&](double z, double) { return speckle_intensity(looks, z); });
    EXPECT_NEAR(mean, 1, 0.015);
    EXPECT_NEAR(variance * looks, 1, looks < 2 ? 0.15 : 0.05) << looks << " looks";
  }
}

TEST(DetectionTheory, NoiseAddsToAKnownEchoAsARice) {
  for (const double echo : {0.0, 3.0, 50.0}) {
    const auto [mean, variance] = moments([&](double z, double) { return received_intensity(echo, 2, z); });
    EXPECT_NEAR(mean / (1 + echo), 1, 0.01);
    EXPECT_NEAR(variance * 2 / (1 + 2 * echo), 1, 0.1) << "of each look: 1 + 2 x echo";
  }
}

TEST(DetectionTheory, SpeckleAndNoiseTogetherAreAnExponentialOfTheSum) {
  for (const double looks : {1.0, 10.0}) {
    const auto [mean, variance] = moments([&](double speckle, double noise) {
      return received_intensity(9 * speckle_intensity(looks, speckle), looks, noise);
    });
    EXPECT_NEAR(mean, 10, 0.2);
    EXPECT_NEAR(variance * looks / 100, 1, looks < 2 ? 0.15 : 0.05);
  }
}

TEST(DetectionTheory, NoisePassesTheThresholdAsOftenForAnyNumberOfLooks) {
  const DetectionThreshold threshold(5);
  const RandomStream stream(8, "noise");
  ASSERT_GT(threshold.false_alarm(), 0.01);
  for (const int looks : {1, 4, 30}) {
    int alarms = 0;
    for (int k = 0; k < kDraws; ++k) {
      double sum = 0;
      for (int look = 0; look < looks; ++look) {
        sum -= std::log(stream.uniform(static_cast<std::uint64_t>(k), static_cast<std::uint32_t>(look)));
      }
      alarms += sum / looks > threshold.intensity(looks);
    }
    EXPECT_NEAR(alarms / (kDraws * threshold.false_alarm()), 1, 0.12) << looks << " looks";
  }
}

TEST(DetectionTheory, HalfOfTheEchoesAreDetectedWithTheSnrNeededWhichFallsWithLooks) {
  const DetectionThreshold threshold(13);
  EXPECT_NEAR(10 * std::log10(threshold.needed_snr(1)), 13, 1e-9);
  double before = 1e9;
  for (const double looks : {1.0, 3.0, 30.0, 100.0}) {
    const double needed = threshold.needed_snr(looks);
    EXPECT_NEAR(threshold.detection_probability(needed, looks), 0.5, 1e-12);
    EXPECT_LT(needed, before);
    before = needed;
    const auto share = moments([&](double speckle, double noise) {
      const double echo = needed * speckle_intensity(looks, speckle);
      return received_intensity(echo, looks, noise) > threshold.intensity(looks) ? 1.0 : 0.0;
    });
    EXPECT_NEAR(share.mean, 0.5, 0.02) << looks << " looks";
  }
  EXPECT_LT(threshold.detection_probability(1, 1), threshold.detection_probability(10, 1));
}

TEST(DetectionTheory, RangeErrorsFallWithSignalAndBandwidthAndByPhaseForLongEchoes) {
  const auto amplitude = [](double extent, double cell, double snr) {
    return amplitude_range_deviation(extent, cell, snr).total_m();
  };
  const auto phase = [](double extent, double cell, double snr) {
    return phase_range_deviation(extent, cell, snr).total_m();
  };
  EXPECT_GT(amplitude(1, 0.03, 2), amplitude(1, 0.03, 20));
  EXPECT_NEAR(amplitude(1, 0.03, 2), 1.5 / std::sqrt(12.0), 1e-12) << "extent / sqrt 12 x (1 + 1/snr)";
  EXPECT_GT(phase(1, 0.03, 2), phase(1, 0.03, 20));
  EXPECT_GT(phase(1, 0.06, 20), phase(1, 0.03, 20));
  EXPECT_NEAR(amplitude(0.03, 0.03, 1e9), 0.03 / std::sqrt(12.0), 1e-9) << "within one cell";
  EXPECT_LT(phase(1, 0.03, 100), 0.2 * amplitude(1, 0.03, 100));
  EXPECT_NEAR(phase(1, 0.01, 20) / phase(1, 0.04, 20), 0.5, 1e-12) << "four times the looks";
  EXPECT_LT(phase_range_deviation(1, 0.03, 1e12).noise_m, 1e-6) << "without noise, speckle remains";
}

}  // namespace
}  // namespace uwsim
