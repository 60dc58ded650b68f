#include "uwsim/camera/ripples.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "uwsim/camera/caustics.h"
#include "uwsim/camera/particle_scattering.h"
#include "uwsim/camera/refraction.h"

namespace uwsim {
namespace {

constexpr double kAfar = std::numeric_limits<double>::infinity();

/// The mean of a level, and its coefficient of variation.
std::pair<double, double> mean_and_cv(const Ripples::Snapshot& snapshot, int level) {
  double sum = 0, square = 0;
  for (std::size_t k = static_cast<std::size_t>(level); k < snapshot.caustics.size(); k += camera::kCausticLevels) {
    sum += snapshot.caustics[k], square += snapshot.caustics[k] * snapshot.caustics[k];
  }
  const double cells = Ripples::kCells * Ripples::kCells, mean = sum / cells;
  return {mean, std::sqrt(std::max(square / cells - mean * mean, 0.0)) / mean};
}

TEST(Ripples, CausticsConserveLightAndSlopesHaveTheVarianceOfCoxAndMunk) {
  const Ripples ripples(5, 0.3, kAfar, 11);
  const Ripples::Snapshot snapshot = ripples.at(3.7, FocusedSun{1.333, {0.4, 0.5}, 0}, 0, 2);
  for (int level = 0; level < camera::kCausticLevels; ++level) {
    EXPECT_NEAR(mean_and_cv(snapshot, level).first, 1, 1e-4) << level;
  }
  double variance = 0;
  for (const float slope : snapshot.slopes) variance += slope * slope;
  EXPECT_NEAR(variance / (Ripples::kCells * Ripples::kCells), 0.5 * (0.003 + 0.00512 * 5), 0.15 * 0.0143);
}

// Waves focus light at depths of some times their length; below, it evens out, the sooner the more the water scatters.
TEST(Ripples, FocusedLightFadesWithDepthAndScattering) {
  const Ripples ripples(5, 0.3, kAfar, 11);
  std::vector<double> clearer(camera::kCausticLevels, 10.0);
  for (const double b : {0.0, 0.05, 0.3}) {
    const Ripples::Snapshot snapshot = ripples.at(3.7, {1.333, {0, 0}, b}, 0, 2);
    std::vector<double> cv;
    for (int level = 0; level < camera::kCausticLevels; ++level) cv.push_back(mean_and_cv(snapshot, level).second);
    const auto most = std::ranges::max_element(cv);
    if (b > 0) {
      EXPECT_TRUE(std::ranges::is_sorted(most, cv.end(), std::greater())) << b;
      EXPECT_LE(most - cv.begin(), 3) << b;                   // at most 4 m deep
      EXPECT_GT(*most, (b > 0.1 ? 1.4 : 1.05) * cv[5]) << b;  // at 16 m
    }
    for (int level = 0; level < camera::kCausticLevels; ++level) EXPECT_LT(cv[level], clearer[level]) << b << level;
    clearer = cv;
  }
}

TEST(Ripples, WavesGrowWithFetchUntilTheSeaIsGrown) {
  // JONSWAP: U = 2 m/s over 400 m: 3.5 (g / U) 981^-0.33 = 1.767 Hz, 0.50 m
  EXPECT_NEAR(longest_wind_wave_m(2, 400), 0.500, 0.002);
  const double grown_hz = 0.13 * 9.80665 / 5;
  EXPECT_NEAR(longest_wind_wave_m(5, 1e6), 9.80665 / (2 * std::numbers::pi * grown_hz * grown_hz), 1e-9);
}

// A pond's ripples are part of the sea's under the same wind: its short ones, whose light is even again in deep water.
TEST(Ripples, AShortFetchLeavesOutTheLongWavesAndTheirFocus) {
  const auto variance = [](const Ripples::Snapshot& snapshot) {
    double sum = 0;
    for (const float slope : snapshot.slopes) sum += slope * slope;
    return sum / (Ripples::kCells * Ripples::kCells);
  };
  const FocusedSun water{1.333, {0, 0}, 0.03};
  const Ripples::Snapshot sea = Ripples(2, 0.3, kAfar, 11).at(3.7, water, 0, 2);
  const Ripples::Snapshot grown = Ripples(5, 0.3, 1e6, 11).at(3.7, water, 0, 2);
  const Ripples::Snapshot pond = Ripples(2, 0.3, 400, 11).at(3.7, water, 0, 2);
  EXPECT_NEAR(variance(grown), 0.5 * (0.003 + 0.00512 * 5), 0.25 * 0.0143) << "nothing shorter than a sea's waves goes";
  // Over octaves of equal variance down to a twentieth of the tile: half of E1(1.25 (0.32 / 0.5)^2) / ln 20.
  EXPECT_NEAR(variance(pond) / variance(sea), 0.5 * 0.54 / std::log(20), 0.04);
  EXPECT_LT(mean_and_cv(pond, 5).second, 0.2 * mean_and_cv(sea, 5).second) << "16 m";
}

TEST(Ripples, ParticlesScatterMostlyForwardsAndLeaveLongPatterns) {
  EXPECT_NEAR(scattered_within(std::numbers::pi), 1, 1e-6);
  EXPECT_NEAR(1 - scattered_within(0.5 * std::numbers::pi), 0.0183, 1e-4);  // Mobley, Sundman and Boss 2002
  EXPECT_NEAR(kept_when_scattered(1e-3), 1, 1e-4);
  EXPECT_EQ(pattern_left(0.2, 1e-9, 10), 1);                       // even light is not changed
  EXPECT_NEAR(pattern_left(0.2, 1e9, 10), std::exp(-1.58), 0.05);  // of fine patterns, what is not scattered
}

// Refracted at an incidence i: (cos w - cos i / n) per slope, and 1 / cos^2 w times as far in the sun's plane.
TEST(Ripples, ALowSunBendsMoreAndMostInItsOwnPlane) {
  const double n = 1.333, in_air = 0.9, in_water = std::asin(std::sin(in_air) / n), slope = 1e-6;
  const auto landed = [&](double slope_x, double slope_y) {
    const Eigen::Vector3d to_sun(std::sin(in_air), 0, std::cos(in_air));
    const Eigen::Vector3d way = *refracted(-to_sun, Eigen::Vector3d(-slope_x, -slope_y, 1).normalized(), 1, n);
    return Eigen::Vector2d(std::cos(in_water) * way.head<2>() / -way.z());  // per metre of the beam's way
  };
  const FocusedSun sun{n, {std::sin(in_air), 0}, 0};
  for (const Eigen::Vector2d& tilt : {Eigen::Vector2d(slope, 0), Eigen::Vector2d(0, slope)}) {
    const Eigen::Vector2d moved = landed(tilt.x(), tilt.y()) - landed(0, 0);
    EXPECT_LT((moved - sun.bend() * moved_on_level(sun.slant(), tilt)).norm(), 1e-4 * slope);
  }
}

}  // namespace
}  // namespace uwsim
