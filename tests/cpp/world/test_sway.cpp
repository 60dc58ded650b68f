#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <span>

#include "meshes.h"
#include "uwsim/world/sway.h"

namespace uwsim {
namespace {

constexpr double kBed_m = 12, kLeans_m_s = 0.3;

/// A bed with plants from 0.5 to 2 m, and therefore of 1 m on average.
World meadow() {
  World world;
  world.set_terrain(Heightfield(std::vector<float>(9, -kBed_m), 3, 3, 10.0, {-10, -10}));
  CoverLayer layer;
  layer.name = "grass";
  layer.meshes = {testing::box(0.1, 0.1, 1)};
  layer.size_m = {0.5, 2};
  layer.leans_at_m_s = kLeans_m_s;
  world.add_cover(layer);
  return world;
}

Eigen::Vector2d lean(const World& world, double time_s) {
  return Sway::of(world, time_s)->lean(*world.cover()[0], {3, -2, -kBed_m});
}

TEST(Sway, StillWaterAndStiffPiecesHaveNone) {
  World world = meadow();
  EXPECT_EQ(Sway::of(world, 0), nullptr);
  World stones;
  stones.set_terrain(*world.terrain());
  CoverLayer stiff = *world.cover()[0];
  stiff.leans_at_m_s = std::numeric_limits<double>::infinity();
  stones.add_cover(stiff);
  stones.water.current_world_m_s = {1, 0, 0};
  EXPECT_EQ(Sway::of(stones, 0), nullptr);
}

TEST(Sway, CurrentLeansPlantsByDragOverBuoyancy) {
  World world = meadow();
  for (const double speed_m_s : {0.05, 0.3, 0.9}) {
    world.water.current_world_m_s = {0.6 * speed_m_s, -0.8 * speed_m_s, 0};
    const double tangent = std::pow(speed_m_s / kLeans_m_s, 2);
    EXPECT_LT((lean(world, 5) - tangent * Eigen::Vector2d(0.6, -0.8)).norm(), 1e-12 * tangent);
  }
}

TEST(Sway, HeldWaterFollowsItsEquation) {
  const Waves sea = Waves::jonswap({.significant_height_m = 1, .peak_period_s = 5, .spreading_exponent = 4}, kBed_m);
  const Eigen::Vector3d at(3, -2, -9);
  constexpr double kStep_s = 1e-4;
  for (const double rate : {0.0, 0.7, 20.0}) {
    for (const double time_s : {0.0, 11.3}) {
      const Eigen::Vector2d x = sea.held_m(at, time_s, rate);
      const Eigen::Vector2d change =
          (sea.held_m(at, time_s + kStep_s, rate) - sea.held_m(at, time_s - kStep_s, rate)) / (2 * kStep_s);
      const Eigen::Vector2d u = sea.motion_at(at, time_s, Eigen::Vector3d::Zero()).velocity_m_s.head<2>();
      EXPECT_LT((change - (u - rate * x)).norm(), 1e-7) << rate;
    }
  }
}

TEST(Sway, MeanSquareIsThatOfTheVelocity) {
  const WaveComponent wave{.amplitude_m = 0.4, .angular_frequency_rad_s = 1.2, .heading_rad = 1, .phase_rad = 0};
  const Waves waves(std::span(&wave, 1), kBed_m);
  double sum = 0;
  constexpr int kTimes = 360;
  for (int k = 0; k < kTimes; ++k) {
    const double time_s = 2 * std::numbers::pi / wave.angular_frequency_rad_s * k / kTimes;
    sum += waves.motion_at({0, 0, -9}, time_s, Eigen::Vector3d::Zero()).velocity_m_s.head<2>().squaredNorm() / kTimes;
  }
  EXPECT_NEAR(waves.mean_square_m2_s2(-9), sum, 1e-9);
}

TEST(Sway, WavesMoveSoftPlantsLikeWaterAndStiffOnesByDrag) {
  const double omega = 2 * std::numbers::pi / 6;
  const WaveComponent wave{.amplitude_m = 0.3, .angular_frequency_rad_s = omega, .heading_rad = 0, .phase_rad = 0};
  const auto waves = std::make_shared<const Waves>(std::span(&wave, 1), kBed_m);
  // The water's excursion at two thirds of a plant's height, and the drag of its speed when the linearised drag of a
  // single wave is that of a sea of the same rms speed.
  const double speed = std::sqrt(2 * waves->mean_square_m2_s2(-kBed_m + 2.0 / 3));
  for (const double leans_at : {0.01, 5.0}) {
    World world;
    world.set_terrain(*meadow().terrain());
    CoverLayer layer = *meadow().cover()[0];
    layer.leans_at_m_s = leans_at;
    world.add_cover(layer);
    world.water.waves = waves;
    double farthest = 0;
    for (double time_s = 0; time_s < 6; time_s += 0.01) farthest = std::max(farthest, lean(world, time_s).norm());
    const double expected =
        leans_at < 1 ? speed / omega : std::sqrt(4 / std::numbers::pi) * speed * speed / (leans_at * leans_at);
    EXPECT_NEAR(farthest / expected, 1, 2e-3) << leans_at;
  }
}

}  // namespace
}  // namespace uwsim
