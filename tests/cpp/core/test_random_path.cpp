#include "uwsim/core/random_path.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace uwsim {
namespace {

const RandomStream kStream(5, "rov/imu/bias");

TEST(RandomPath, AStepDoesNotDependOnTheStepsReadBefore) {
  RandomPath in_order = RandomPath::gauss_markov(kStream, 2, 0.3, 50);
  std::vector<double> values;
  for (std::uint64_t k = 0; k < 1000; ++k) values.push_back(in_order.at(k));
  RandomPath jumping = RandomPath::gauss_markov(kStream, 2, 0.3, 50);
  for (std::uint64_t k = 0; k < 1000; ++k) {
    const std::uint64_t step = (k * 617) % 1000;
    jumping.at(step * 1'000'003);
    EXPECT_EQ(jumping.at(step), values[step]);
  }
  RandomPath other = RandomPath::gauss_markov(kStream, 3, 0.3, 50);
  EXPECT_NE(other.at(17), values[17]);
}

TEST(RandomPath, AGaussMarkovProcessHasItsStandardDeviationAndExponentialCorrelation) {
  constexpr double kStd = 0.3, kTime = 20;
  constexpr std::size_t kSteps = 400'000;
  RandomPath process = RandomPath::gauss_markov(kStream, 0, kStd, kTime);
  std::vector<double> values;
  for (std::uint64_t k = 0; k < kSteps; ++k) values.push_back(process.at(k));
  for (const std::size_t lag : {0, 1, 7, 20, 60}) {
    double products = 0;
    for (std::size_t k = 0; k + lag < kSteps; ++k) products += values[k] * values[k + lag];
    // Five standard errors; the number of independent draws is about N / (2 correlation times).
    const double tolerance = 5 * kStd * kStd * std::sqrt(2 * kTime / kSteps);
    EXPECT_NEAR(products / kSteps, kStd * kStd * std::exp(-static_cast<double>(lag) / kTime), tolerance) << lag;
  }
}

TEST(RandomPath, ARandomWalkStartsAtZeroAndHasIndependentSteps) {
  RandomPath walk = RandomPath::random_walk(kStream, 0, 0.01);
  EXPECT_EQ(walk.at(0), 0);
  constexpr int kSteps = 200'000;
  double squares = 0, products = 0, before = 0;
  for (std::uint64_t k = 0; k < kSteps; ++k) {
    const double step = (walk.at(k + 1) - walk.at(k)) / 0.01;
    squares += step * step;
    products += step * before;
    before = step;
  }
  EXPECT_NEAR(squares / kSteps, 1, 5 * std::sqrt(2.0 / kSteps));
  EXPECT_NEAR(products / kSteps, 0, 5 / std::sqrt(kSteps));
}

TEST(RandomPath, TheStandardDeviationOfARandomWalkGrowsWithTheRootOfTime) {
  constexpr int kPaths = 4000;
  for (const std::uint64_t steps : {std::uint64_t{1}, std::uint64_t{1000}, std::uint64_t{1} << 33}) {
    double squares = 0;
    for (std::uint32_t path = 0; path < kPaths; ++path) {
      squares += std::pow(RandomPath::random_walk(kStream, path, 1).at(steps), 2) / static_cast<double>(steps);
    }
    EXPECT_NEAR(squares / kPaths, 1, 5 * std::sqrt(2.0 / kPaths)) << steps;
  }
}

}  // namespace
}  // namespace uwsim
