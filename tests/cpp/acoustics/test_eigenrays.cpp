#include "uwsim/acoustics/modem/eigenrays.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "acoustics/profile_of.h"
#include "uwsim/acoustics/sound_path.h"
#include "uwsim/core/check.h"

namespace uwsim {
namespace {

constexpr double kDeep = std::numeric_limits<double>::infinity();

TEST(Eigenrays, InEvenWaterTheyAreStraightAndBounceAsInMirrors) {
  const auto profile = SoundSpeedProfile::even(1500);
  const double from = 12, to = 30, across = 400, bottom = 45;
  const auto rays = eigenrays(profile, {from, to, across, bottom});
  ASSERT_EQ(rays.size(), 5u);
  // Heights of the receiver's images: direct, surface, bottom, surface then bottom, bottom then surface.
  for (const Eigenray& ray : rays) {
    double rise = 0;
    if (ray.surface_bounces == 0 && ray.bottom_bounces == 0) rise = to - from;
    if (ray.surface_bounces == 1 && ray.bottom_bounces == 0) rise = from + to;
    if (ray.surface_bounces == 0 && ray.bottom_bounces == 1) rise = 2 * bottom - from - to;
    if (ray.surface_bounces == 1 && ray.bottom_bounces == 1) {
      rise = ray.launch_dip_rad < 0 ? 2 * bottom + from - to : 2 * bottom - from + to;
    }
    EXPECT_NEAR(ray.length_m, std::hypot(across, rise), 1e-9);
    EXPECT_NEAR(ray.time_s, ray.length_m / 1500, 1e-12);
    EXPECT_NEAR(std::abs(std::tan(ray.launch_dip_rad)), rise / across, 1e-12);
  }
}

TEST(Eigenrays, ALevelRayInEvenWaterIsAsLongAsItsEndsAreApart) {
  const auto rays = eigenrays(SoundSpeedProfile::even(1480), {20, 20, 1000, kDeep}, false);
  ASSERT_EQ(rays.size(), 1u);
  EXPECT_NEAR(rays[0].time_s, 1000.0 / 1480, 1e-9);
}

TEST(Eigenrays, AVerticalRayTakesTheIntegralOfSlowness) {
  const auto profile = profile_of({0, 100}, {1450, 1550});
  const auto rays = eigenrays(profile, {10, 90, 0, kDeep}, false);
  ASSERT_EQ(rays.size(), 1u);
  EXPECT_NEAR(rays[0].time_s, std::log(1540.0 / 1460), 1e-12) << "integral of dz / (1450 + z)";
  EXPECT_NEAR(rays[0].length_m, 80, 1e-9);
}

/// A ray launched at an eigenray's dip reaches the other end after its travel time.
void expect_reached(const SoundSpeedProfile& profile, const RayEnds& ends, const Eigenray& ray) {
  const SoundState end = travel(profile, ends.from_depth_m, ray.launch_dip_rad, ray.time_s);
  EXPECT_NEAR(end.across_m, ends.across_m, 2e-5 * ends.across_m);
  EXPECT_NEAR(end.depth_m, ends.to_depth_m, 2e-5 * ends.across_m);
  EXPECT_NEAR(end.length_m, ray.length_m, 1e-5 * ends.across_m);
  EXPECT_NEAR(end.dip_rad, ray.arrival_dip_rad, 1e-4);
}

TEST(Eigenrays, TheyReachTheOtherEndThroughLayers) {
  const auto summer = profile_of({0, 5, 15, 60}, {1480, 1478, 1440, 1435});
  const auto channel = profile_of({0, 50, 200}, {1500, 1480, 1490});
  for (const SoundSpeedProfile& profile : {summer, channel}) {
    for (const double to : {8.0, 20.0, 45.0}) {
      for (const double across : {10.0, 60.0, 150.0}) {
        const RayEnds ends{20, to, across, kDeep};
        const auto rays = eigenrays(profile, ends, false);
        ASSERT_FALSE(rays.empty()) << to << " m deep, " << across << " m away";
        for (const Eigenray& ray : rays) expect_reached(profile, ends, ray);
      }
    }
  }
}

TEST(Eigenrays, UnderAConstantGradientALevelRayIsTheArcOfACircle) {
  const double slope = 0.02;  // upward refraction: sound is faster below
  const auto profile = profile_of({0, 2000}, {1480, 1480 + slope * 2000});
  const double depth = 500, across = 3000, c = 1480 + slope * depth;
  const auto rays = eigenrays(profile, {depth, depth, across, kDeep}, false);
  ASSERT_EQ(rays.size(), 1u);
  EXPECT_NEAR(std::tan(rays[0].launch_dip_rad), slope * across / (2 * c), 1e-6);
  EXPECT_NEAR(rays[0].time_s, 2 / slope * std::asinh(slope * across / (2 * c)), 1e-8);
  EXPECT_LT(rays[0].time_s, across / c) << "the arc is faster than the straight line";
}

TEST(Eigenrays, BelowAWarmLayerThereIsAShadowZone) {
  // Sound bends down, away from the surface; the limiting ray grazes it.
  const double slope = -0.5;
  const auto profile = profile_of({0, 100}, {1500, 1450});
  const double from = 10, to = 10;
  const double c = 1500 + slope * from;
  // For a ray that turns at the surface, half of its chord is sqrt(c0^2 - c^2) / |g|, with p = 1 / c0.
  const double limit = 2 * std::sqrt(1500.0 * 1500 - c * c) / -slope;
  EXPECT_FALSE(eigenrays(profile, {from, to, 0.99 * limit, kDeep}, false).empty());
  EXPECT_TRUE(eigenrays(profile, {from, to, 1.01 * limit, kDeep}, false).empty());
}

TEST(Eigenrays, RefusesEndsOutOfTheWater) {
  EXPECT_THROW(eigenrays(SoundSpeedProfile::even(1500), {-1, 5, 10, 20}), InvalidValue);
  EXPECT_THROW(eigenrays(SoundSpeedProfile::even(1500), {1, 25, 10, 20}), InvalidValue);
}

}  // namespace
}  // namespace uwsim
