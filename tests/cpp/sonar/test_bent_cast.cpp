#include "uwsim/sonar/bent_cast.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <numbers>
#include <optional>
#include <random>
#include <set>
#include <vector>

#include "meshes.h"
#include "sonar/imaging_pool.h"
#include "uwsim/acoustics/sound_path.h"
#include "uwsim/core/instruction_set.h"
#include "uwsim/sonar/bent_kernels.h"
#include "uwsim/sonar/water_sound.h"
#include "uwsim/world/sea_water.h"

namespace uwsim {
namespace {

SoundSpeedProfile gradient(double surface_m_s, double gradient_1_s, double depth_m = 1000) {
  const std::vector<double> depths = {0, depth_m}, speeds = {surface_m_s, surface_m_s + gradient_1_s * depth_m};
  return SoundSpeedProfile(depths, speeds);
}

Eigen::Vector3d dipping(double dip_rad, double heading_rad = 0) {
  return {std::cos(dip_rad) * std::cos(heading_rad), std::cos(dip_rad) * std::sin(heading_rad), -std::sin(dip_rad)};
}

SoundHit cast_one(const RayScene& scene, const SoundSpeedProfile& profile, const Eigen::Vector3d& from,
                  const Eigen::Vector3d& direction, double time_max_s = 2) {
  SoundHit hit;
  cast_bent(scene, profile, from, {&direction, 1}, time_max_s, {&hit, 1});
  return hit;
}

TEST(BentCast, UnderAConstantGradientTheHitOnAFlatBedLiesOnSnellsCircle) {
  const double g = 0.1, c0 = 1450;
  const auto profile = gradient(c0, g);
  const RayScene scene(testing::flat_bed(-60, 2000));
  for (const double dip : {0.15, 0.3, 0.8, 1.5}) {
    const double depth = 10, c = c0 + g * depth, c_bed = c0 + g * 60;
    const double dip_bed = std::acos(std::cos(dip) * c_bed / c);
    const double across = c / (g * std::cos(dip)) * (std::sin(dip) - std::sin(dip_bed));
    const auto gd = [](double a) { return std::log(std::tan(std::numbers::pi / 4 + a / 2)); };
    const double time = (gd(dip) - gd(dip_bed)) / g;
    const SoundHit hit = cast_one(scene, profile, {3, 4, -depth}, dipping(dip, 0.7));
    // A ray in float is off by 2e-4 m; moving a hit from its chord onto the arc leaves as much, at the flattest dip
    // here.
    const double slack_m = 5e-4 / std::sin(dip_bed) + 2e-4;
    EXPECT_NEAR(std::hypot(hit.point_world_m.x() - 3, hit.point_world_m.y() - 4), across, slack_m);
    EXPECT_NEAR(hit.point_world_m.z(), -60, 5e-4);
    EXPECT_NEAR(hit.time_s, time, slack_m / c);
    EXPECT_NEAR(std::asin(-hit.arrival_world.z()), dip_bed, 1e-4);
    EXPECT_EQ(hit.label, kTerrain);
  }
}

TEST(BentCast, ChordsStayWithinTwoThousandthsOfTheDistanceOfTheArc) {
  // Thin poles along the arc of a level ray are hit or missed as by the arc, not as by a straight line.
  const auto profile = gradient(1450, 0.5, 400);
  const double c = 1450 + 0.5 * 50, radius = c / 0.5;
  for (const double across : {20.0, 40.0, 80.0}) {
    const double rise_m = radius - std::sqrt(radius * radius - across * across);
    for (const double off_m : {-2.1e-3 * across, 2.1e-3 * across}) {
      World world;
      TriangleMesh box = testing::box(0.1, 10, 2);  // its top is 1 m above its centre
      for (auto& v : box.vertices_m) v += Eigen::Vector3d(across + 0.05, 0, -50 + rise_m - 1 + off_m);
      world.add_solid("box", box);
      const SoundHit hit = cast_one(RayScene(world), profile, {0, 0, -50}, dipping(0), 0.2);
      EXPECT_EQ(hit.label != kNothing, off_m > 0) << across << " m, " << off_m;
    }
  }
}

TEST(BentCast, AHitLiesOnThePathThroughManyLayersAndOnTheSurface) {
  // Speeds fall and rise again, a layer every two metres: chords pass several layers and end anywhere in one.
  std::vector<double> depths, speeds;
  for (int level = 0; level <= 30; ++level) {
    depths.push_back(2.0 * level);
    speeds.push_back(1500 - 8 * std::sin(0.3 * level));
  }
  const SoundSpeedProfile profile(depths, speeds);
  TriangleMesh slope;
  slope.vertices_m = {{-500, -500, -80}, {500, -500, -20}, {500, 500, -20}, {-500, 500, -80}};
  slope.triangles = {{0, 1, 2}, {0, 2, 3}};
  World world;
  world.add_solid("slope", slope);
  const RayScene scene(world);
  for (const double dip : {0.2, 0.4, 0.9, 1.4}) {
    for (const double heading : {0.0, 1.0, 2.5}) {
      const SoundHit hit = cast_one(scene, profile, {0, 0, -4}, dipping(dip, heading));
      ASSERT_NE(hit.label, kNothing) << dip << " " << heading;
      const SoundState there = travel(profile, 4, dip, hit.time_s);
      const double across = std::hypot(hit.point_world_m.x(), hit.point_world_m.y());
      EXPECT_NEAR(there.across_m, across, 1e-6);
      EXPECT_NEAR(there.depth_m, -hit.point_world_m.z(), 1e-6);
      EXPECT_NEAR(there.length_m, hit.length_m, 1e-6);
      EXPECT_NEAR(hit.point_world_m.z(), -50 + 0.06 * hit.point_world_m.x(), 5e-4) << "on the slope";
    }
  }
}

TEST(BentCast, ARisingRayHitsSubmergedObstaclesButNothingAboveTheSurface) {
  const auto profile = gradient(1450, 0.5, 400);
  World world;
  TriangleMesh box = testing::box(1, 20, 40);
  for (auto& v : box.vertices_m) v += Eigen::Vector3d(600, 0, 20.1);  // from z = 0.1 up
  world.add_solid("bridge", box);
  const RayScene scene(world);
  EXPECT_EQ(cast_one(scene, profile, {0, 0, -20}, dipping(0.05)).label, kNothing) << "ends at the surface before";
  EXPECT_EQ(cast_one(scene, profile, {590, 0, -1}, dipping(-0.3)).label, kNothing);
  EXPECT_EQ(cast_one(scene, profile, {590, 0, 1}, dipping(-0.3)).label, kNothing) << "a dry head";
  EXPECT_EQ(cast_one(scene, profile, {590, 0, 0}, dipping(-0.3)).label, kNothing);
}

TEST(BentCast, InHomogeneousWaterItIsAStraightCastOfOneChord) {
  const RayScene scene(testing::flat_bed(-30, 2000));
  const auto even = SoundSpeedProfile::even(1500);
  const Eigen::Vector3d direction = dipping(0.4);
  SoundHit hit;
  EXPECT_EQ(cast_bent(scene, even, {0, 0, -10}, {&direction, 1}, 1, {&hit, 1}), 1u);
  EXPECT_NEAR(hit.length_m, 20 / std::sin(0.4), 2e-4);
  EXPECT_NEAR(hit.time_s, 20 / std::sin(0.4) / 1500, 2e-7);
  EXPECT_EQ(cast_one(scene, even, {0, 0, -10}, direction, 0.02).label, kNothing) << "not within the time";
}

/// Rays from a depth, from steeply up to steeply down, and their next chords.
struct Traced {
  BentRays rays{};
  alignas(64) float rows[7][kBentTogether] = {};
  alignas(64) std::int32_t active[kBentTogether] = {};
  PathHits placed{};

  Traced(const BentKernels& kernels, const SoundSpeedProfile& profile, double depth_m) {
    DirectionRows directions;
    for (std::size_t k = 0; k < kBentTogether; ++k) {
      const Eigen::Vector3d direction = dipping(dip_rad(k));
      directions.x[k] = direction.x(), directions.y[k] = direction.y(), directions.z[k] = direction.z();
    }
    const auto layer = [&](bool rises) { return static_cast<std::int32_t>(profile.layer_ahead(depth_m, rises)); };
    kernels.start(profile.layers().data(), {depth_m, profile.at(depth_m), layer(false), layer(true)}, directions, rays);
  }

  static double dip_rad(std::size_t ray) { return -1.5 + 0.2 * static_cast<double>(ray); }

  /// Traces a chord, with a hit a third along it.
  void trace(const BentKernels& kernels, const SoundSpeedProfile& profile, double depth_m) {
    kernels.next_chords(profile.layers().data(), depth_m, 0.5, rays,
                        {rows[0], rows[1], rows[2], rows[3], rows[4], rows[5], rows[6], active});
    alignas(64) float distance_m[kBentTogether], zero[kBentTogether] = {}, one[kBentTogether];
    for (std::size_t k = 0; k < kBentTogether; ++k) distance_m[k] = rows[6][k] / 3, one[k] = 1;
    kernels.place_hits(rays, depth_m, {distance_m, zero, zero, one, active}, placed);
  }
};

TEST(BentKernels, AllInstructionSetsGiveTheSameBits) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> speed(1450, 1550);
  std::vector<double> depths, speeds;
  for (int level = 0; level < 40; ++level) depths.push_back(5.0 * level), speeds.push_back(speed(random));
  const SoundSpeedProfile profile(depths, speeds);
  const auto expect_same = [&](const BentKernels& kernels, double depth_m) {
    Traced one(baseline_bent_kernels(), profile, depth_m), other(kernels, profile, depth_m);
    for (std::size_t k = 0; k < kBentTogether; ++k) {
      EXPECT_NEAR(one.rays.end.dip_rad[k], Traced::dip_rad(k), 4e-16);
      EXPECT_EQ(one.rays.end.dip_rad[k], other.rays.end.dip_rad[k]);
    }
    int chords = 0;
    for (; chords < 500 && !std::ranges::all_of(one.rays.done, [](std::int32_t done) { return done != 0; }); ++chords) {
      one.trace(baseline_bent_kernels(), profile, depth_m);
      other.trace(kernels, profile, depth_m);
      ASSERT_EQ(std::memcmp(one.active, other.active, sizeof one.active), 0) << chords;
      for (std::size_t k = 0; k < kBentTogether; ++k) {
        if (one.active[k] == 0) continue;
        for (std::size_t row = 0; row < std::size(one.rows); ++row) ASSERT_EQ(one.rows[row][k], other.rows[row][k]);
        EXPECT_EQ(one.placed.time_s[k], other.placed.time_s[k]);
        EXPECT_EQ(one.placed.x[k], other.placed.x[k]);
        EXPECT_EQ(one.placed.z[k], other.placed.z[k]);
        EXPECT_EQ(one.placed.arrival_z[k], other.placed.arrival_z[k]);
        one.rays.done[k] |= one.rays.surfaces[k], other.rays.done[k] |= other.rays.surfaces[k];
      }
    }
    EXPECT_GT(chords, 10);
  };
  for (const double depth_m : {3.0, 20.0, 150.0}) {
    if (processor_has(InstructionSet::avx2)) expect_same(avx2_bent_kernels(), depth_m);
    if (processor_has(InstructionSet::avx512)) expect_same(avx512_bent_kernels(), depth_m);
  }
}

TEST(WaterSound, TheProfileFollowsTheWaterBetweenItsLevelsAndBelowThem) {
  Water water;
  water.select_sound_speed_equation("automatic");
  water.surface_temperature_deg_c = 18;
  water.bottom_temperature_deg_c = 6;
  water.bottom_depth_m = 40;
  const SoundSpeedProfile profile = sound_speed_profile(water);
  for (double depth = 0; depth < 12000; depth += depth < 60 ? 0.7 : 97) {
    EXPECT_NEAR(profile.at(depth), water.sound_speed_m_s(-depth), 0.05) << depth;
  }
  water.profile = std::make_shared<const WaterProfile>(
      std::vector{WaterLevel{.depth_m = 3, .temperature_deg_c = 20, .salinity_psu = 0},
                  WaterLevel{.depth_m = 30, .temperature_deg_c = 8, .salinity_psu = 35}});
  water.select_sound_speed_equation("automatic");
  const SoundSpeedProfile brackish = sound_speed_profile(water);
  for (double depth = 0; depth < 60; depth += 0.3) {
    EXPECT_NEAR(brackish.at(depth), water.sound_speed_m_s(-depth), 0.06) << depth;
  }
}

/// Random water for a world: linear in depth, a table of a few levels, or a cast with many levels.
class AnyWater {
 public:
  explicit AnyWater(std::uint64_t seed) : random_(seed) {}

  Water draw(int kind) {
    Water water;
    water.bottom_depth_m = std::pow(11000.0, between(0, 1));
    water.surface_temperature_deg_c = between(-2, 40);
    water.bottom_temperature_deg_c = between(0, 1) < 0.3 ? water.surface_temperature_deg_c : between(-2, 40);
    water.salinity_psu = between(0, 1) < 0.2 ? 0 : between(0, 42);
    water.density_kg_m3 = sea_water_density_kg_m3(water.surface_temperature_deg_c, water.salinity_psu);
    if (kind > 0) water.profile = std::make_shared<const WaterProfile>(levels(water, kind == 1 ? 7 : 200));
    water.select_sound_speed_equation("automatic");
    return water;
  }
  double between(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }

 private:
  std::vector<WaterLevel> levels(const Water& water, int most) {
    std::set<double> depths = {between(0, 1) < 0.5 ? 0 : between(0, water.bottom_depth_m)};
    const int count = static_cast<int>(between(1, most));
    while (static_cast<int>(depths.size()) < count) depths.insert(between(0, water.bottom_depth_m));
    std::vector<WaterLevel> levels;
    double t = between(-2, 40), s = water.salinity_psu;
    const double step = most > 10 ? 2 : 40;
    for (const double depth : depths) {
      levels.push_back({depth, t, s, sea_water_density_kg_m3(t, s)});
      t = std::clamp(t + between(-step, step), -2.0, 40.0);
      if (water.salinity_psu > 0) s = std::clamp(s + between(-step, step), 0.0, 42.0);
    }
    return levels;
  }

  std::mt19937_64 random_;
};

TEST(WaterSound, TenThousandWatersOfTheWorldHaveAProfileThatFollowsTheirEquation) {
  AnyWater any(1);
  double worst_m_s = 0;
  for (int k = 0; k < 10000; ++k) {
    const Water water = any.draw(k % 3);
    SCOPED_TRACE(::testing::Message() << "water " << k << ": " << water.range().text());
    std::optional<SoundSpeedProfile> profile;
    ASSERT_NO_THROW(profile = sound_speed_profile(water));
    for (int place = 0; place < 20; ++place) {
      const double depth = place == 0 ? water.bottom_depth_m : any.between(0, water.bottom_depth_m);
      worst_m_s = std::max(worst_m_s, std::abs(profile->at(depth) - water.sound_speed_m_s(-depth)));
    }
  }
  EXPECT_LT(worst_m_s, 0.06);
}

TEST(WaterSound, TheDeepestLevelOfAnyBottomIsThatOfTheOcean) {
  Water water;
  for (const double bottom_m : {18.762875, 5.25, 0.001, 11999.99, 12000.0, std::nextafter(12000.0, 0)}) {
    water.bottom_depth_m = bottom_m;
    EXPECT_EQ(sound_speed_profile(water).layers().back().top_m, 12000) << bottom_m;
  }
}

TEST(WaterSound, LevelsThatNearlyTouchHaveNoneBetween) {
  Water water;
  const double above = 100, below = std::nextafter(above, 200);
  water.profile = std::make_shared<const WaterProfile>(std::vector{
      WaterLevel{.depth_m = above, .temperature_deg_c = 30}, WaterLevel{.depth_m = below, .temperature_deg_c = 5}});
  const SoundSpeedProfile profile = sound_speed_profile(water);
  EXPECT_DOUBLE_EQ(profile.at(above), water.sound_speed_m_s(-above));
  EXPECT_DOUBLE_EQ(profile.at(below), water.sound_speed_m_s(-below));
}

}  // namespace
}  // namespace uwsim
