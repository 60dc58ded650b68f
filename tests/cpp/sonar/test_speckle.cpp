#include <gtest/gtest.h>

#include <cmath>

#include "sonar/imaging_pool.h"

namespace uwsim {
namespace {

struct Moments {
  double mean, deviation;
};

template <typename Value>
Moments moments(int n, Value value) {
  double sum = 0, squares = 0;
  for (int k = 0; k < n; ++k) {
    const double x = value(k);
    sum += x;
    squares += x * x;
  }
  return {sum / n, std::sqrt(squares / n - sum * sum / n / n)};
}

ImagingReceiver receiver(int looks, double noise_db) {
  testing::ImagingModel model = testing::quiet_forward_looking();
  model["looks"] = looks;
  model["noise_level_db"] = noise_db;
  return {model.acoustics(), 0.1, RandomStream(3, "speckle")};
}

constexpr int kCells = 200000;
constexpr double kEcho = 1e-18;  // 20 dB re 1 uPa from a source of 200 dB

TEST(Speckle, AmplitudeIsRayleigh) {
  const ImagingReceiver subject = receiver(1, testing::kSilence_db);
  const auto amplitude = [&](int k) { return std::sqrt(subject.received(kEcho, 5, static_cast<std::uint32_t>(k))); };
  const auto [mean, deviation] = moments(kCells, amplitude);
  EXPECT_NEAR(mean, 10 * std::sqrt(std::numbers::pi) / 2, 0.05);
  EXPECT_NEAR(mean / deviation, 1.9131, 0.02) << "sqrt(pi / (4 - pi))";
  int below = 0;
  for (int k = 0; k < kCells; ++k) below += amplitude(k) < 10;
  EXPECT_NEAR(1.0 * below / kCells, 1 - std::exp(-1), 0.005) << "exp(-A^2 / mean power) are above A";
}

TEST(Speckle, LooksReduceTheDeviationByTheRootOfTheirNumber) {
  for (const int looks : {1, 4, 16}) {
    const ImagingReceiver subject = receiver(looks, testing::kSilence_db);
    const auto [mean, deviation] =
        moments(kCells, [&](int k) { return subject.received(kEcho, 5, static_cast<std::uint32_t>(k)); });
    EXPECT_NEAR(mean, 100, 1);
    EXPECT_NEAR(mean / deviation, std::sqrt(looks), 0.02 * std::sqrt(looks));
  }
  EXPECT_NEAR(receiver(0, testing::kSilence_db).received(kEcho, 0, 0), 100, 1e-9) << "no looks, no speckle";
}

TEST(Speckle, CellsAndPingsAreIndependent) {
  const ImagingReceiver subject = receiver(1, testing::kSilence_db);
  double cells = 0, pings = 0;
  for (std::uint32_t k = 0; k < kCells; ++k) {
    cells += (subject.received(kEcho, 5, k) / 100 - 1) * (subject.received(kEcho, 5, k + 1) / 100 - 1);
    pings += (subject.received(kEcho, 5, k) / 100 - 1) * (subject.received(kEcho, 6, k) / 100 - 1);
  }
  EXPECT_NEAR(cells / kCells, 0, 0.015);
  EXPECT_NEAR(pings / kCells, 0, 0.015);
}

TEST(Speckle, NoiseAddsAsPower) {
  const ImagingReceiver subject = receiver(0, 20);
  EXPECT_NEAR(subject.received(kEcho, 0, 0), 200, 1e-9);
  EXPECT_NEAR(subject.received(0, 0, 0), 100, 1e-9);
}

}  // namespace
}  // namespace uwsim
