#include "uwsim/acoustics/arrivals.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "acoustics/profile_of.h"
#include "uwsim/acoustics/sound_path.h"
#include "uwsim/core/check.h"
#include "uwsim/core/random.h"

namespace uwsim {
namespace {

constexpr double kBottomless = std::numeric_limits<double>::infinity();
constexpr SoundLosses kSand{25e3, {1.9, 1.1, 0.8}};

std::vector<Arrival> direct(const SoundSpeedProfile& profile, const RayEnds& ends) {
  return arrivals(profile, ends, kSand, {.most_bounces = 0});
}

TEST(Arrivals, InEvenWaterTheyAreThoseOfAllMirrorImages) {
  const double from = 12, to = 30, across = 400, bottom = 45;
  const auto all =
      arrivals(SoundSpeedProfile::even(1500), {from, to, across, bottom}, {25e3, {1.9, 1.1, 0}}, {.within_db = 30});
  const double critical = std::acos(1 / 1.1);
  std::size_t expected = 0;
  for (int image = -30; image <= 30; ++image) {
    for (const int side : {-1, 1}) {
      const double rise = 2 * bottom * image + side * to - from, grazing = std::atan2(std::abs(rise), across);
      if (grazing > critical) continue;  // these lose some in the bottom
      ++expected;
      const double length = std::hypot(across, rise);
      const auto same = [&](const Arrival& one) {
        return std::abs(std::tan(one.launch_dip_rad) * across - rise) < 1e-6;
      };
      const auto found = std::find_if(all.begin(), all.end(), same);
      ASSERT_NE(found, all.end()) << "image at " << rise << " m";
      EXPECT_NEAR(found->length_m, length, 1e-9);
      EXPECT_NEAR(found->time_s, length / 1500, 1e-12);
      EXPECT_NEAR(found->level_db, -20 * std::log10(length), 1e-9);
      // An image is as many bottoms away as the ray has bounced, off both boundaries
      const int bounces = side > 0 ? 2 * std::abs(image) : std::abs(2 * image - 1);
      EXPECT_EQ(found->surface_bounces + found->bottom_bounces, bounces);
      EXPECT_EQ(found->turns, 0);
    }
  }
  EXPECT_GE(expected, 8u);
}

TEST(Arrivals, ALevelRayInEvenWaterIsAsLongAsItsEndsAreApart) {
  const auto all = direct(SoundSpeedProfile::even(1480), {20, 20, 1000, kBottomless});
  ASSERT_EQ(all.size(), 1u);
  EXPECT_NEAR(all[0].time_s, 1000.0 / 1480, 1e-9);
  EXPECT_NEAR(all[0].level_db, -60, 1e-6);
}

TEST(Arrivals, AVerticalRayTakesTheIntegralOfSlowness) {
  const auto all = direct(profile_of({0, 100}, {1450, 1550}), {10, 90, 0, kBottomless});
  ASSERT_EQ(all.size(), 1u);
  EXPECT_NEAR(all[0].time_s, std::log(1540.0 / 1460), 1e-12) << "integral of dz / (1450 + z)";
  EXPECT_NEAR(all[0].length_m, 80, 1e-9);
}

TEST(Arrivals, UnderAConstantGradientALevelRayIsTheArcOfACircle) {
  const double slope = 0.02, depth = 500, across = 3000, c = 1480 + slope * depth;
  const auto all = direct(profile_of({0, 2000}, {1480, 1480 + slope * 2000}), {depth, depth, across, kBottomless});
  ASSERT_EQ(all.size(), 1u);
  EXPECT_NEAR(std::tan(all[0].launch_dip_rad), slope * across / (2 * c), 1e-6);
  EXPECT_NEAR(all[0].time_s, 2 / slope * std::asinh(slope * across / (2 * c)), 1e-8);
  EXPECT_EQ(all[0].turns, 1);
}

TEST(Arrivals, BelowAWarmLayerThereIsAShadowZoneOfTheDirectRayOnly) {
  const double slope = -0.5, c = 1500 + slope * 10;
  const auto profile = profile_of({0, 100}, {1500, 1450});
  // For a ray that turns at the surface, half of its chord is sqrt(c0^2 - c^2) / |g|, with p = 1 / c0.
  const double limit = 2 * std::sqrt(1500.0 * 1500 - c * c) / -slope;
  EXPECT_FALSE(direct(profile, {10, 10, 0.99 * limit, kBottomless}).empty());
  EXPECT_TRUE(direct(profile, {10, 10, 1.01 * limit, kBottomless}).empty());
  EXPECT_FALSE(arrivals(profile, {10, 10, 1.01 * limit, 100}, kSand).empty()) << "the bottom reflects sound into it";
}

/// A profile of random layers: ducts, channels and slopes.
SoundSpeedProfile random_profile(std::uint64_t seed, double bottom_m) {
  const RandomStream stream(seed, "profile");
  std::vector<double> depths = {0}, speeds = {1480};
  for (std::uint64_t k = 0; k < 5; ++k) {
    depths.push_back(bottom_m * static_cast<double>(k + 1) / 5 - (k < 4 ? 15 * stream.uniform(k) : 0));
    speeds.push_back(speeds.back() + 16 * (stream.uniform(k, 1) - 0.5));
  }
  return profile_of(depths, speeds);
}

struct Landing {
  double depth_m;
  int surface, bottom;
};

/// Where a ray is after some distance, traced arc by arc (SoundPath) and reflected by hand.
Landing traced(const SoundSpeedProfile& profile, const RayEnds& ends, double dip_rad) {
  Landing at{ends.from_depth_m, 0, 0};
  double across_m = 0;
  for (int leg = 0; leg < 200; ++leg) {
    SoundPath path(profile, at.depth_m, dip_rad);
    for (;;) {
      const SoundPath::Step step = path.step(1e7);
      if (across_m + step.end.across_m >= ends.across_m) {
        double low = 0, high = step.end.length_m - path.state().length_m;  // of this layer's arc
        for (int k = 0; k < 60; ++k) {
          const double middle = 0.5 * (low + high);
          (across_m + path.ahead(middle).across_m < ends.across_m ? low : high) = middle;
        }
        at.depth_m = path.ahead(low).depth_m;
        return at;
      }
      const bool surfaced = path.advance(step);
      const SoundState& state = path.state();
      const bool grounded = state.depth_m >= ends.bottom_m - 1e-9 && state.dip_rad > 0;
      if (!surfaced && !grounded) continue;
      across_m += state.across_m;
      at.depth_m = surfaced ? 0 : ends.bottom_m;
      dip_rad = -state.dip_rad;
      ++(surfaced ? at.surface : at.bottom);
      break;
    }
  }
  return at;
}

/// Returns whether the depth passes the receiver's without a jump between two dips: rays split at levels that they
/// graze.
bool is_continuous(const SoundSpeedProfile& profile, const RayEnds& ends, double low, double high) {
  const auto above = [&](double dip) { return traced(profile, ends, dip).depth_m < ends.to_depth_m; };
  const bool low_above = above(low);
  for (int k = 0; k < 30; ++k) {
    const double middle = 0.5 * (low + high);
    (above(middle) == low_above ? low : high) = middle;
  }
  return std::abs(traced(profile, ends, low).depth_m - traced(profile, ends, high).depth_m) < 0.1;
}

TEST(Arrivals, NoneIsMissingOfThoseThatAFanOfTracedRaysFinds) {
  int found = 0;
  for (const std::uint64_t seed : {1, 2, 3, 4, 5, 6}) {
    const double bottom = 100;
    const auto profile = random_profile(seed, bottom);
    const RayEnds ends{15.0 + 10 * static_cast<double>(seed), 48, 700, bottom};
    const auto all = arrivals(profile, ends, {25e3, {1.9, 0.999, 0}}, {.within_db = 400});
    Landing last{};
    constexpr int kRays = 2000;
    const auto dip_of = [](int k) { return -0.6 + 1.2 * (k + 0.37) / kRays; };
    for (int k = 0; k < kRays; ++k) {
      const Landing next = traced(profile, ends, dip_of(k));
      const bool same = k > 0 && last.surface == next.surface && last.bottom == next.bottom;
      const bool crosses = same && (last.depth_m < ends.to_depth_m) != (next.depth_m < ends.to_depth_m);
      if (crosses && is_continuous(profile, ends, dip_of(k - 1), dip_of(k))) {
        ++found;
        const auto between = [&](const Arrival& one) {
          return one.surface_bounces == next.surface && one.bottom_bounces == next.bottom &&
                 one.launch_dip_rad > dip_of(k - 1) && one.launch_dip_rad < dip_of(k);
        };
        EXPECT_NE(std::find_if(all.begin(), all.end(), between), all.end())
            << "seed " << seed << ", dip " << dip_of(k) << " rad";
      }
      last = next;
    }
    for (const Arrival& one : all) {
      if (std::abs(one.launch_dip_rad) > 0.6) continue;
      EXPECT_NEAR(traced(profile, ends, one.launch_dip_rad).depth_m, ends.to_depth_m, 1e-4);
    }
  }
  EXPECT_GT(found, 50);
}

TEST(Arrivals, SourceAndReceiverAreInterchangeable) {
  for (const std::uint64_t seed : {11, 12, 13}) {
    const auto profile = random_profile(seed, 80);
    const auto there = arrivals(profile, {20, 61, 900, 80}, kSand), back = arrivals(profile, {61, 20, 900, 80}, kSand);
    ASSERT_EQ(there.size(), back.size());
    for (std::size_t k = 0; k < there.size(); ++k) {
      EXPECT_NEAR(there[k].time_s, back[k].time_s, 1e-11);
      EXPECT_NEAR(there[k].level_db, back[k].level_db, 1e-6);
      EXPECT_NEAR(there[k].launch_dip_rad, -back[k].arrival_dip_rad, 1e-9);
    }
  }
}

TEST(Arrivals, ATubesLevelIsThatOfItsNeighbourhood) {
  // dr / dlaunch from the launch angles of the rays to two receivers 2 cm apart
  const auto profile = random_profile(21, 100);
  const auto near = arrivals(profile, {30, 55, 599.99, 100}, {25e3, {1.9, 0.999, 0}}, {.within_db = 400});
  const auto far = arrivals(profile, {30, 55, 600.01, 100}, {25e3, {1.9, 0.999, 0}}, {.within_db = 400});
  int compared = 0;
  for (const Arrival& a : near) {
    for (const Arrival& b : far) {
      const double step = b.launch_dip_rad - a.launch_dip_rad;
      if (a.surface_bounces != b.surface_bounces || a.bottom_bounces != b.bottom_bounces || std::abs(step) > 1e-3)
        continue;
      const double spread =
          std::cos(a.launch_dip_rad) / (600 * (0.02 / std::abs(step)) * std::abs(std::sin(a.arrival_dip_rad)));
      const double lost = a.bottom_bounces * bottom_loss_db({1.9, 0.999, 0}, a.bottom_grazing_rad);
      EXPECT_NEAR(a.level_db, 10 * std::log10(spread * profile.at(55) / profile.at(30)) - lost, 0.02);
      ++compared;
    }
  }
  EXPECT_GT(compared, 8);
}

TEST(Arrivals, AbsorptionAddsUpAlongTheRay) {
  const AbsorptionColumn five([](double) { return 5.0; }, 100);
  SoundLosses lossy = kSand;
  lossy.absorption = &five;
  const auto profile = random_profile(31, 100);
  const auto clear = arrivals(profile, {30, 55, 600, 100}, kSand), dim = arrivals(profile, {30, 55, 600, 100}, lossy);
  for (std::size_t k = 0; k < std::min(clear.size(), dim.size()); ++k) {
    EXPECT_NEAR(clear[k].level_db - dim[k].level_db, 5e-3 * clear[k].length_m, 1e-9);
  }
}

TEST(Arrivals, RefuseEndsOutOfTheWater) {
  EXPECT_THROW(arrivals(SoundSpeedProfile::even(1500), {-1, 5, 10, 20}, kSand), InvalidValue);
  EXPECT_THROW(arrivals(SoundSpeedProfile::even(1500), {1, 25, 10, 20}, kSand), InvalidValue);
}

}  // namespace
}  // namespace uwsim
