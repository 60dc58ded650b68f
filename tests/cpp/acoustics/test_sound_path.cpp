#include "uwsim/acoustics/sound_path.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "acoustics/profile_of.h"
#include "uwsim/core/check.h"

namespace uwsim {
namespace {

/// The ray equations, integrated by a fourth-order Runge-Kutta method in small time steps.
SoundState integrated(const SoundSpeedProfile& profile, double depth_m, double dip_rad, double time_s, int steps) {
  using State = Eigen::Vector3d;  // across, depth, dip
  const auto rate = [&](const State& s) {
    const SoundLayer& layer = profile.layers()[profile.layer_at(s.y())];
    const double c = layer.at(s.y());
    return State(c * std::cos(s.z()), c * std::sin(s.z()), -layer.gradient_1_s * std::cos(s.z()));
  };
  State s(0, depth_m, dip_rad);
  const double h = time_s / steps;
  for (int k = 0; k < steps; ++k) {
    const State a = rate(s), b = rate(s + 0.5 * h * a), c = rate(s + 0.5 * h * b), d = rate(s + h * c);
    s += h / 6 * (a + 2 * b + 2 * c + d);
  }
  return {s.x(), s.y(), s.z(), time_s, 0};
}

TEST(SoundPath, InHomogeneousWaterThePathIsStraight) {
  const auto profile = SoundSpeedProfile::even(1480);
  for (const double dip : {-0.3, 0.0, 0.7, std::numbers::pi / 2}) {
    const SoundState end = travel(profile, 100, dip, 0.05);
    EXPECT_NEAR(end.across_m, 74 * std::cos(dip), 1e-9);
    EXPECT_NEAR(end.depth_m, 100 + 74 * std::sin(dip), 1e-9);
    EXPECT_NEAR(end.length_m, 74, 1e-9);
  }
}

TEST(SoundPath, UnderAConstantGradientThePathIsSnellsCircle) {
  const double c0 = 1450;
  const auto profile = profile_of({0, 1000}, {c0, c0 + 250});
  const double slope = 0.25, depth = 400, dip = 0.6;
  const double c = c0 + slope * depth;
  // A circle of radius c / (g cos dip) about the depth at which the speed would be zero.
  const double radius = c / (slope * std::cos(dip)), still_m = -c0 / slope;
  for (const double time : {0.02, 0.1, 0.25}) {
    const SoundState end = travel(profile, depth, dip, time);
    const double centre_across = radius * std::sin(dip);
    EXPECT_NEAR(std::hypot(end.across_m - centre_across, end.depth_m - still_m), radius, 1e-8);
    EXPECT_NEAR(std::cos(end.dip_rad) / (c0 + slope * end.depth_m), std::cos(dip) / c, 1e-15) << "Snell";
    // t = 1/g times the difference of ln tan(pi/4 + dip/2)
    const auto gd = [](double a) { return std::log(std::tan(std::numbers::pi / 4 + a / 2)); };
    EXPECT_NEAR((gd(dip) - gd(end.dip_rad)) / slope, time, 1e-12);
  }
}

TEST(SoundPath, StraightDownTheTimeIsTheLogarithmOfTheRatioOfSpeeds) {
  const auto profile = profile_of({0, 500}, {1500, 1450});
  const double time = std::log(1500.0 / 1450) / 0.1;
  const SoundState end = travel(profile, 0, std::numbers::pi / 2, time);
  EXPECT_NEAR(end.depth_m, 500, 1e-7);
  EXPECT_NEAR(end.across_m, 0, 1e-9);
}

TEST(SoundPath, ThroughLayersThePathFollowsTheRayEquations) {
  const auto profile = profile_of({0, 20, 35, 36, 80, 300}, {1490, 1488, 1462, 1461, 1466, 1470});
  for (const double dip : {-0.9, -0.25, 0.02, 0.3, 1.2}) {
    const SoundState end = travel(profile, 33, dip, 0.02);
    const SoundState reference =
        integrated(profile, 33, dip, 0.02, 20000);  // a change of slope costs the reference part of a step
    EXPECT_NEAR(end.across_m, reference.across_m, 2e-5);
    EXPECT_NEAR(end.depth_m, reference.depth_m, 2e-5);
    EXPECT_NEAR(end.dip_rad, reference.dip_rad, 1e-6);
  }
}

TEST(SoundPath, ThePathTurnsInFasterWaterAndOscillatesAboutTheChannelAxis) {
  const auto profile = profile_of({0, 100, 200}, {1500, 1480, 1500});
  double deepest = 0, shallowest = 1000;
  for (int k = 1; k < 400; ++k) {
    const SoundState now = travel(profile, 100, 0.08, 0.005 * k);
    deepest = std::max(deepest, now.depth_m);
    shallowest = std::min(shallowest, now.depth_m);
  }
  // The ray turns where c = c0 / cos dip: 4.75 m/s faster, 23.8 m off the axis.
  const double turn_m = 1480 * (1 / std::cos(0.08) - 1) / 0.2;
  EXPECT_NEAR(deepest, 100 + turn_m, 0.05);
  EXPECT_NEAR(shallowest, 100 - turn_m, 0.05);
}

TEST(SoundPath, ThePathEndsAtTheSurface) {
  const auto profile = profile_of({0, 100}, {1500, 1490});
  const SoundState end = travel(profile, 10, -0.5, 1);
  EXPECT_NEAR(end.depth_m, 0, 1e-9);
  EXPECT_LT(end.time_s, 0.02);
  EXPECT_EQ(travel(profile, 0, -0.5, 1).time_s, 0);
}

TEST(SoundSpeedProfile, RefusesInvalidLevels) {
  EXPECT_THROW(profile_of({}, {}), InvalidValue);
  EXPECT_THROW(profile_of({0, 10}, {1480}), InvalidValue);
  EXPECT_THROW(profile_of({0, 10, 10}, {1480, 1480, 1480}), InvalidValue);
  EXPECT_THROW(profile_of({0, 10, 5}, {1480, 1480, 1480}), InvalidValue);
  EXPECT_THROW(profile_of({0, 10}, {1480, 340}), InvalidValue);
  EXPECT_THROW(profile_of({0, std::numeric_limits<double>::quiet_NaN()}, {1480, 1480}), InvalidValue);
  try {
    profile_of({0, 10, 5}, {1480, 1480, 1480});
  } catch (const InvalidValue& error) {
    EXPECT_STREQ(error.what(), "sound_speed_profile.depths_m[2] = 5 m: must be deeper than the level before");
  }
}

}  // namespace
}  // namespace uwsim
