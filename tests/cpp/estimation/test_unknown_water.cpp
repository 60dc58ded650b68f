#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <random>
#include <utility>

#include "uwsim/estimation/navigation_filter.h"

namespace uwsim {
namespace {

constexpr double kWeight_m_s2 = 9.80665;
constexpr std::uint64_t kSample_ns = 10'000'000;
constexpr int kLevelError = 3;  // among the depth gauge's biases

using Height = std::function<double(double)>;  // [m], by time [s]

/// A dive straight down or up, under water of which the filter knows `water`. The start is known within
/// 0.1 m; every second there is a fix of the position, within `fix_std`, unless that is 0.
struct Dive {
  WaterErrors water;
  Height z = [](double) { return -10.0; };
  /// The reading of a gauge without noise at this time and height.
  std::function<double(double, double)> gauge = [](double, double z) { return -z; };
  double fix_std = 0, seconds = 60;
};

struct Dived {
  std::unique_ptr<NavigationFilter> filter;
  double z_error, z_std, level, level_std;
};

Dived dived(const Dive& dive, unsigned seed = 1) {
  ImuErrors imu{.rate_std = 1e-4,
                .force_std = 1e-3,
                .period_s = 0.01,
                .rate_bias = {1e-5, 0, 0, 0},
                .force_bias = {1e-3, 0, 0, 0}};
  auto filter = std::make_unique<NavigationFilter>(imu, Eigen::Vector3d::Zero(), kWeight_m_s2);
  const int depth = filter->add_aid(depth_aid({0, 0, 0}, 0.01, {0.01, 0, 0, 0}, dive.water));
  const int dvl = filter->add_aid(doppler_aid(-Eigen::Matrix3d::Identity(), {0, 0, 0}, {0.01, {0.001, 0, 0, 0}}));
  const int fix = filter->add_aid(acoustic_fix_aid({0, 0, 0}, {dive.fix_std, dive.fix_std / 20}));
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  constexpr double kDt = 1e-9 * kSample_ns;
  const auto speed = [&](double t) { return (dive.z(t + kDt) - dive.z(t - kDt)) / (2 * kDt); };
  FilterStart start;
  start.world_from_body.position_m.z() = dive.z(0) + 0.1 * normal(random);
  start.position_std_m.setConstant(0.1);
  start.velocity_std_m_s = 0.01;
  start.attitude_std_rad.setConstant(1e-3);
  start.velocity_world_m_s.z() = speed(0);
  filter->start(start);
  for (std::uint64_t k = 1; 1e-9 * static_cast<double>(k * kSample_ns) <= dive.seconds; ++k) {
    const std::uint64_t now = k * kSample_ns;
    const double t = 1e-9 * static_cast<double>(now), z = dive.z(t);
    const double force = kWeight_m_s2 + (speed(t) - speed(t - kDt)) / kDt + 1e-3 * normal(random);
    const std::array<double, 6> sample = {0, 0, 0, 0, 0, force};
    filter->add_imu(now, sample.data());
    const double shown = dive.gauge(t, z) + 0.01 * normal(random);
    if (k % 10 == 0) filter->add_reading(depth, now, now, &shown);
    const std::array<double, 3> beams = {0.01 * normal(random), 0.01 * normal(random),
                                         -speed(t) + 0.01 * normal(random)};
    if (k % 20 == 0) filter->add_reading(dvl, now, now, beams.data());
    const std::array<double, 6> found = {-20 + dive.fix_std * normal(random), dive.fix_std * normal(random),
                                         z + dive.fix_std * normal(random), 20};
    if (k % 100 == 0 && dive.fix_std > 0) filter->add_reading(fix, now, now, found.data());
    filter->catch_up();
  }
  const FilterState& state = filter->state();
  const int level = filter->first_bias(depth) + kLevelError;
  const double z_std = std::sqrt(state.covariance(kPosition + 2, kPosition + 2));
  const double level_std = std::sqrt(state.covariance(level, level));
  const double z = state.position_m.z(), at = state.aid_bias[level - kAidBias];
  return {std::move(filter), z - dive.z(dive.seconds), z_std, at, level_std};
}

/// A gauge measures the sum of depth and tide. If the start shows how deep it is, the rest is the tide; neither is then
/// known better than the start, and their sum is known as well as the gauge.
TEST(UnknownWater, AGaugeAloneDoesNotTellTheTideFromTheDepth) {
  constexpr double kTide = 1.3;
  const Dived high = dived({.water = {.level_std_m = 1}, .gauge = [](double, double z) { return kTide - z; }});
  EXPECT_LT(std::abs(high.z_error), 3 * high.z_std);
  EXPECT_NEAR(high.z_std, 0.1, 0.01);
  EXPECT_NEAR(high.level, kTide, 3 * high.level_std);
  EXPECT_NEAR(high.level - high.z_error, kTide, 0.04);  // the gauge's bias, and its noise
  EXPECT_EQ(high.filter->state().doubts, 0U);
}

/// While a tide runs and nothing else measures the height, the height becomes as uncertain as the tide is.
TEST(UnknownWater, WithoutAReferenceTheHeightIsAsUncertainAsTheTide) {
  constexpr double kStd = 1;
  const Dived soon = dived({.water = {.level_std_m = kStd}, .seconds = 60});
  Dive adrift{.water = {.level_std_m = kStd}, .seconds = 1800};
  adrift.gauge = [](double t, double z) { return 0.3 * std::sin(2e-4 * t) - z; };
  const Dived late = dived(adrift);
  // the rate has the standard deviation 2 pi / 12.42 h times that of the level
  EXPECT_GT(late.z_std, 0.8 * 1.405e-4 * kStd * 1800);
  EXPECT_GT(late.z_std, 1.5 * soon.z_std);
  EXPECT_LT(std::abs(late.z_error), 3 * late.z_std);
}

/// Fixes of the position observe the height, and so the tide.
TEST(UnknownWater, FixesShowTheTide) {
  Dive dive{.water = {.level_std_m = 1.5}, .fix_std = 0.5, .seconds = 600};
  dive.gauge = [](double t, double z) { return -2 + 3e-4 * t - z; };
  const Dived known = dived(dive);
  EXPECT_NEAR(known.level, -2 + 3e-4 * 600, 3 * known.level_std);
  EXPECT_LT(known.level_std, 0.1);
  EXPECT_LT(std::abs(known.z_error), 3 * known.z_std);
  for (const AidCounts& counts : known.filter->state().counts) EXPECT_LE(counts.rejected, 1U);
}

/// Below a layer of lighter water, the gauge's depth grows faster than the depth: 2 % here.
TEST(UnknownWater, HeavierWaterBelowIsNotMoreDepth) {
  Dive dive{.water = {.column_std = 0.02}, .seconds = 160};
  dive.z = [](double t) { return -10 - 5 * (1 - std::cos(t / 160 * EIGEN_PI)); };  // to 20 m
  dive.gauge = [](double, double z) { return -z + 0.02 * std::max(0.0, -z - 10); };
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const Dived deep = dived(dive, seed);
    EXPECT_LT(std::abs(deep.z_error), 3 * deep.z_std);
    EXPECT_LT(deep.z_std, 0.3);
    EXPECT_EQ(deep.filter->state().doubts, 0U);
  }
}

/// Going up and down in water of one density reveals no other: the height does not drift, however uncertain the column.
TEST(UnknownWater, UpAndDownInEvenWaterTheHeightStays) {
  Dive dive{.water = {.column_std = 0.023}, .seconds = 600};
  dive.z = [](double t) { return -10 + 0.5 * (1 - std::cos(2 * EIGEN_PI / 10 * t)); };
  double sum = 0;
  for (unsigned seed = 1; seed <= 4; ++seed) sum += dived(dive, seed).z_error;
  EXPECT_LT(std::abs(sum / 4), 0.08);
}

/// A surface that rises faster than any tide where none is expected, as in a lock: fixes contradict the gauge until the
/// filter doubts what it knows of the water, and then takes the fixes again.
TEST(UnknownWater, FixesAreTakenAgainAfterTheWaterHasMisled) {
  Dive dive{.water = {.level_std_m = 0.005}, .fix_std = 0.1, .seconds = 900};
  dive.gauge = [](double t, double z) { return (t < 300 ? 0 : std::min((t - 300) / 100, 1.0)) - z; };
  const Dived after = dived(dive);
  EXPECT_LT(std::abs(after.z_error), 0.1);
  const AidCounts& fixes = after.filter->state().counts[2];
  EXPECT_LT(static_cast<double>(fixes.rejected), 0.1 * static_cast<double>(fixes.accepted));
}

/// The water, as far as it is known, belongs to the filter's state.
TEST(UnknownWater, ASavedFilterGoesOnWithTheSameWater) {
  const Dive dive{.water = {.level_std_m = 1, .column_std = 0.01}, .fix_std = 0.5};
  const Dived one = dived(dive, 1), other = dived(dive, 2);
  ASSERT_NE(one.level, other.level);
  other.filter->restore(one.filter->save());
  EXPECT_EQ(one.filter->state().aid_bias, other.filter->state().aid_bias);
  EXPECT_EQ(one.filter->state().covariance, other.filter->state().covariance);
}

}  // namespace
}  // namespace uwsim
