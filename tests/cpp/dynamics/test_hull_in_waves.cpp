#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <thread>
#include <vector>

#include "dynamics/bodies.h"
#include "uwsim/dynamics/integrator.h"
#include "uwsim/world/water.h"

namespace uwsim {
namespace {

Water with_wave(double amplitude_m, double period_s, double heading_rad = 0, double depth_m = 40) {
  const WaveComponent wave{amplitude_m, 2 * std::numbers::pi / period_s, heading_rad, 0.4};
  Water water;
  water.waves = std::make_shared<const Waves>(std::span(&wave, 1), depth_m);
  return water;
}

Eigen::Quaterniond tilted(double angle) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d(0.3, -0.7, 0.2).normalized()));
}

Buoyancy buoyancy(const BuoyantHull& hull, const Pose& pose, const WaterField& water, double time_s) {
  return hull.buoyancy(pose.position_m, pose.rotation(), water, time_s);
}

/// Force and moment of the pressure on the wet surface: each edge is divided into `parts`, and the pressure is that at
/// the middle of each small triangle.
Vector6d load_of_pressure(const TriangleMesh& mesh, const Pose& pose, const WaterField& water, double time_s,
                          int parts) {
  Vector6d load = Vector6d::Zero();
  for (const Triangle& t : mesh.triangles) {
    const Eigen::Vector3d &a = mesh.vertices_m[t[0]], &b = mesh.vertices_m[t[1]], &c = mesh.vertices_m[t[2]];
    const Eigen::Vector3d inward = -0.5 * (b - a).cross(c - a) / (parts * parts);
    for (int i = 0; i < parts; ++i) {
      for (int j = 0; j < 2 * (parts - i) - 1; ++j) {  // j even: a triangle like the whole; odd: one upside down
        const double third = j % 2 == 0 ? 1.0 / 3 : 2.0 / 3;
        const Eigen::Vector3d at = a + (i + third) / parts * (b - a) + (j / 2 + third) / parts * (c - a);
        const double head_m = water.pressure_head_at(pose.point(at), time_s);
        if (head_m <= 0) continue;
        const Eigen::Vector3d force = water.still_pressure_at(-head_m) * inward;
        load.head<3>() += force;
        load.tail<3>() += at.cross(force);
      }
    }
  }
  return load;
}

TEST(HullInWaves, TheForceOnAFloatingBoxIsThePressureUnderItsBottom) {
  const BuoyantHull hull(testing::box(2, 1, 1));
  const Water water = with_wave(0.15, 2.5, 0.5);
  for (double t = 0; t < 2.5; t += 0.25) {
    double sum = 0;
    constexpr int kCells = 40;
    for (int i = 0; i < kCells; ++i) {
      for (int j = 0; j < kCells; ++j) {
        const Eigen::Vector3d p(2 * ((i + 0.5) / kCells - 0.5), (j + 0.5) / kCells - 0.5, -0.5);
        sum += water.still_pressure_at(-water.pressure_head_at(p, t)) * 2 / (kCells * kCells);
      }
    }
    const Buoyancy got = buoyancy(hull, {{0, 0, 0}, Eigen::Quaterniond::Identity()}, water, t);
    EXPECT_NEAR(got.force_body_n.z(), sum, 3e-3 * sum) << t;
  }
}

/// Slices are cut when the hull first meets waves, by whichever thread is first.
TEST(HullInWaves, AHullThatSeveralThreadsShareIsCutOnce) {
  const TriangleMesh mesh = testing::box(2, 1, 1);
  const Water water = with_wave(0.15, 1.2);
  const Pose pose{{0, 0, 0}, tilted(0.3)};
  const Buoyancy expected = buoyancy(BuoyantHull(mesh), pose, water, 0.5);
  const BuoyantHull shared(mesh);
  std::array<Buoyancy, 4> got;
  {
    std::vector<std::jthread> threads;
    for (Buoyancy& mine : got) threads.emplace_back([&] { mine = buoyancy(shared, pose, water, 0.5); });
  }
  for (const Buoyancy& mine : got) {
    EXPECT_EQ(mine.force_body_n, expected.force_body_n);
    EXPECT_EQ(mine.moment_body_nm, expected.moment_body_nm);
  }
}

/// The second wave is so short that the hull is cut into slices.
TEST(HullInWaves, WithinAStepAHullIsFollowedAndBeyondItIsCutAgain) {
  const BuoyantHull hull(testing::box(2, 1, 1));
  for (const double period_s : {4.0, 1.2}) {
    const Water water = with_wave(0.1, period_s);
    NearbyWater nearby;
    const auto error = [&](double time_s) {  // relative; of a hull that rises at 0.3 m/s and turns at 0.5 rad/s
      const Pose pose{{0, 0, 0.1 + 0.3 * time_s}, tilted(0.3 + 0.5 * time_s)};
      const Buoyancy exact = buoyancy(hull, pose, water, time_s);
      const Buoyancy got = hull.buoyancy(pose.position_m, pose.rotation(), water, time_s, &nearby);
      return (got.force_body_n - exact.force_body_n).norm() / exact.force_body_n.norm() +
             (got.moment_body_nm - exact.moment_body_nm).norm() / exact.force_body_n.norm();
    };
    EXPECT_EQ(error(0), 0);
    for (const double time_s : {0.0025, 0.005}) {
      EXPECT_GT(error(time_s), 0);
      EXPECT_LT(error(time_s), 1e-4);
    }
    EXPECT_EQ(error(0.3), 0);
  }
}

TEST(HullInWaves, BelowTheWavesTheClosedFormEqualsTheIntegralOfPressure) {
  const TriangleMesh mesh = testing::moved(testing::box(1.6, 0.6, 0.4), {0.2, 0.1, 0});
  const BuoyantHull hull(mesh);
  for (const double depth : {6.0, 40.0}) {
    const Water water = with_wave(0.02, 2.5, 0.9, depth);
    const Pose pose{{1, 2, -2}, tilted(0.8)};
    const Vector6d still = load_of_pressure(mesh, pose, EvenWater{}, 0, 24);
    for (const double t : {0.0, 0.7, 1.9}) {
      const Vector6d load = load_of_pressure(mesh, pose, water, t, 24) - still;
      const Eigen::Vector3d force = load.head<3>(), moment = load.tail<3>();
      const Buoyancy got = buoyancy(hull, pose, water, t), calm = buoyancy(hull, pose, EvenWater{}, t);
      EXPECT_LT((got.force_body_n - calm.force_body_n - force).norm(), 0.02 * force.norm());
      EXPECT_LT((got.moment_body_nm - calm.moment_body_nm - moment).norm(), 0.02 * force.norm());
    }
  }
}

/// In steep waves, with any attitude and draught, and in water of several densities.
TEST(HullInWaves, TheForceOnAFloatingHullIsThatOfThePressureOnItsWetSurface) {
  const TriangleMesh box = brick(), ball = testing::sphere(0.5, 12);
  Water layered = with_wave(0.25, 2.5, 0.9);  // a k = 0.16
  WaterLevel top, bottom;
  top.density_kg_m3 = 1000;
  bottom.depth_m = 4;
  bottom.density_kg_m3 = 1030;
  layered.profile = std::make_shared<const WaterProfile>(std::array{top, bottom});
  for (const TriangleMesh* mesh : {&box, &ball}) {
    const BuoyantHull hull(*mesh);
    for (const Water& water : {with_wave(0.25, 2.5, 0.9), with_wave(0.2, 4, -0.4, 3), layered}) {
      double worst = 0, worst_moment = 0;
      for (int k = 0; k < 12; ++k) {
        const double t = 0.3 * k;
        const double surface_m = water.surface_height_at(1, 2, t);
        const Pose pose{{1, 2, surface_m + 0.07 * (k % 5 - 2)}, tilted(0.3 * k)};
        const Vector6d want = load_of_pressure(*mesh, pose, water, t, mesh == &box ? 24 : 3);
        const Buoyancy got = buoyancy(hull, pose, water, t);
        worst = std::max(worst, (got.force_body_n - want.head<3>()).norm() / want.head<3>().norm());
        worst_moment = std::max(worst_moment, (got.moment_body_nm - want.tail<3>()).norm() / want.head<3>().norm());
      }
      EXPECT_LT(worst, 0.02);
      EXPECT_LT(worst_moment, 0.004) << "m";
    }
  }
}

TEST(HullInWaves, DeepDownThereIsNoWaveForce) {
  const BuoyantHull hull(brick());
  const Pose pose{{1, 2, -100}, tilted(0.8)};
  EXPECT_EQ(buoyancy(hull, pose, with_wave(0.3, 3, 0, 200), 1).force_body_n,
            buoyancy(hull, pose, EvenWater{}, 1).force_body_n);
}

TEST(HullInWaves, TheForceIsContinuousFromTheAirToTheDeep) {
  const BuoyantHull hull(brick());
  const Water water = with_wave(0.3, 3);
  Eigen::Vector3d last = Eigen::Vector3d::Zero();
  for (double z = 1.5; z > -4; z -= 1e-3) {
    const Eigen::Vector3d force = buoyancy(hull, {{0, 0, z}, tilted(0.5)}, water, 0.9).force_body_n;
    EXPECT_LT((force - last).norm(), 1e-3 * 9806.65 * 1.6) << z;
    last = force;
  }
}

const TriangleMesh kSmall = testing::box(0.12, 0.08, 0.06);
const Vector6d kAddedToSmall(0.2, 0.5, 1.4, 1e-4, 1e-4, 1e-4);

/// A small neutrally buoyant body without drag that starts with the water's velocity stays with the water, in waves and
/// a current. Like a water particle, it drifts along but does not rise or sink.
TEST(HullInWaves, ANeutralBodyWithoutDragStaysWithTheWater) {
  CraftParameters p = solid_of(kSmall, 1000);
  p.added_mass.diagonal() = kAddedToSmall;
  p.linear_damping.diagonal().tail<3>().setConstant(0.01);  // keeps it level
  const Craft craft(p, BuoyantHull(kSmall));
  Water water = with_wave(0.25, 4);
  for (const double current_m_s : {0.0, 0.5}) {
    water.current_world_m_s.x() = current_m_s;
    BodyState state = at(0, 0, -5);
    state.velocity_body.head<3>() = water.flow_at(state.world_from_body.position_m, 0).velocity_m_s;
    constexpr double kLong_s = 0.02;
    for (int k = 0; k < 3000; ++k) state = advance(craft, state, {}, water, kLong_s * k, kLong_s);
    // Its mean height over the last period.
    double middle_m = 0;
    const double period_s = 4 / (1 - current_m_s * 2 * std::numbers::pi / (4 * 9.80665));
    const int steps = static_cast<int>(period_s / kLong_s);
    for (int k = 0; k < steps; ++k) {
      state = advance(craft, state, {}, water, 60 + kLong_s * k, kLong_s);
      middle_m += state.world_from_body.position_m.z() / steps;
      const Eigen::Vector3d slip = state.world_from_body.orientation * state.velocity_body.head<3>() -
                                   water.flow_at(state.world_from_body.position_m, 60 + kLong_s * (k + 1)).velocity_m_s;
      EXPECT_LT(slip.norm(), 0.001) << "of orbits at 0.11 m/s";
    }
    EXPECT_NEAR(middle_m, -5, 0.1) << current_m_s << ": within an orbit of the start";
  }
}

TEST(HullInWaves, ANeutralBodyWithoutDampingIsCarriedByARisingTide) {
  CraftParameters p = brick_parameters(1000);
  p.added_mass.diagonal() << 100, 300, 900, 20, 50, 40;
  const Craft craft(p, BuoyantHull(brick()));
  Water water;
  water.currents = {tidal_current({0.5, 0.2, 0}, 100, 0)};
  BodyState state = at(0, 0, -10);
  for (int k = 0; k < 1000; ++k) state = advance(craft, state, {}, water, 0.02 * k, 0.02);
  const Eigen::Vector3d current = water.flow_at(state.world_from_body.position_m, 20).velocity_m_s;
  EXPECT_LT((state.velocity_body.head<3>() - current).norm(), 1e-6);
}

/// Under a tide, a hull is where it would be in still water whose surface stood at the same height above it.
TEST(HullInWaves, ATideRaisesTheHullsWaterline) {
  const BuoyantHull hull(testing::box(1.2, 0.8, 1.0));
  Water water;
  water.tide = std::make_shared<const Tide>(std::vector<TidalConstituent>{{1.5, 1.4e-4, 0.3}});
  water.profile = std::make_shared<const WaterProfile>(
      std::vector<WaterLevel>{{0, 15, 30, 1020}, {2, 10, 33, 1026}, {9, 10, 33, 1027}});
  Water still = water;
  still.tide = nullptr;
  for (const double time_s : {0.0, 9e3, 2e4}) {
    const double level_m = water.surface_height_at(0, 0, time_s);
    EXPECT_NEAR(level_m, 1.5 * std::cos(1.4e-4 * time_s - 0.3), 1e-12);
    for (const double z : {0.3, -0.4, -1.9, -6.0}) {
      const Pose raised{{2, 1, z + level_m}, tilted(0.4)}, low{{2, 1, z}, tilted(0.4)};
      const Buoyancy got = buoyancy(hull, raised, water, time_s), expected = buoyancy(hull, low, still, 0);
      EXPECT_LT((got.force_body_n - expected.force_body_n).norm(), 1e-9 * expected.force_body_n.norm());
      EXPECT_LT((got.moment_body_nm - expected.moment_body_nm).norm(), 1e-9 * expected.force_body_n.norm());
      EXPECT_NEAR(hull.submerged_volume_m3(raised, water, time_s), expected.volume_m3, 1e-12);
    }
  }
}

/// The period of the waves is much longer than that of the box, so the box neither lags nor overshoots much.
TEST(HullInWaves, AFloatingBoxHeavesWithLongWaves) {
  CraftParameters p = brick_parameters(500);
  p.centre_of_mass_body_m = {0, 0, -0.15};
  p.added_mass.diagonal() << 50, 100, 300, 10, 20, 20;
  p.linear_damping.diagonal() << 100, 100, 1500, 80, 80, 80;
  const Craft craft(p, BuoyantHull(brick()));
  const Water water = with_wave(0.1, 9);
  BodyState state;
  double worst = 0;
  for (int k = 0; k < 2000; ++k) {
    const double t = 0.02 * k;
    if (t > 25) {
      const Eigen::Vector3d& at = state.world_from_body.position_m;
      worst = std::max(worst, std::abs(at.z() - water.surface_height_at(at.x(), at.y(), t)));
    }
    state = advance(craft, state, {}, water, t, 0.02);
  }
  EXPECT_LT(worst, 0.012) << "of waves 0.1 m high";
}

}  // namespace
}  // namespace uwsim
