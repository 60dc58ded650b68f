#include "uwsim/dynamics/hull_waves.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "dynamics/bodies.h"

namespace uwsim {
namespace {

constexpr double kCommonPeriod_s = 20;
constexpr double kLeast_rad_s = 1, kMost_rad_s = 5;

/// D, which varies linearly with the frequency and not with the heading: what the table has between its rows.
Radiation::Drift drift_at(double omega_rad_s) { return (omega_rad_s - kLeast_rad_s) * Radiation::Drift(300, 20, -7); }

/// A box that floats half submerged, without any waves of first order.
std::shared_ptr<const Craft> drifting_box() {
  auto table = std::make_shared<Radiation>();
  table->added_mass.diagonal().setConstant(1);
  table->frequencies = 2;
  table->headings = 4;
  table->least_rad_s = kLeast_rad_s;
  table->most_rad_s = kMost_rad_s;
  table->wet_volume_m3 = 0.5;
  for (std::size_t division = 0; division < Radiation::kDivisions; ++division) {
    for (const double omega : {kLeast_rad_s, kMost_rad_s}) {
      table->drift.insert(table->drift.end(), table->headings, drift_at(omega));
      table->diffraction.insert(table->diffraction.end(), table->headings, Radiation::Force::Zero());
    }
  }
  table->check();
  CraftParameters p;
  p.mass_kg = 500;
  p.inertia_kg_m2 = 80 * Eigen::Matrix3d::Identity();
  p.radiation = table;
  return craft_of(p, testing::box(2, 1, 0.5));
}

/// Small waves from ahead at multiples of a common frequency.
std::vector<WaveComponent> small_sea() {
  std::vector<WaveComponent> sea;
  for (int k = 0; k < 9; ++k)
    sea.push_back({1e-3 * (1 + k % 4), 2 * std::numbers::pi * (5 + k) / kCommonPeriod_s, 0, 1.7 * k * k});
  return sea;
}

Water water_with(const std::vector<WaveComponent>& sea) {
  Water water;
  water.waves = std::make_shared<const Waves>(sea, 200);
  return water;
}

BodyState at_depth(double depth_m) { return at(3, -2, -depth_m); }

Vector6d only_slow(const Radiation::Drift& drift) {
  Vector6d wrench = Vector6d::Zero();
  wrench << drift(0), drift(1), 0, 0, 0, drift(2);
  return wrench;
}

/// Newman 1974: in an irregular sea the mean is the sum of each wave's own, 2 int S D d omega in its limit.
TEST(HullWaves, TheMeanDriftInASeaIsTheSumOfThatInEachOfItsWaves) {
  const std::vector<WaveComponent> sea = small_sea();
  const Water water = water_with(sea);
  const HullWaves waves("box", drifting_box(), water, 0.01);
  Vector6d mean = Vector6d::Zero(), expected = Vector6d::Zero();
  constexpr int kInstants = 64;
  for (int k = 0; k < kInstants; ++k)
    mean += waves.wrenches_at(at_depth(0), water, kCommonPeriod_s * k / kInstants).diffraction / kInstants;
  for (const WaveComponent& wave : sea)
    expected += wave.amplitude_m * wave.amplitude_m * only_slow(drift_at(wave.angular_frequency_rad_s));
  EXPECT_LT((mean - expected).norm(), 1e-9 * expected.norm());
}

/// In two waves it varies with their difference only, by the mean of their drifts.
TEST(HullWaves, TheDriftInTwoWavesVariesWithTheirDifference) {
  const std::vector<WaveComponent> two = {{2e-3, 2.0, 0, 0.3}, {3e-3, 2.5, 0, 1.1}};
  const Water water = water_with(two);
  const HullWaves waves("box", drifting_box(), water, 0.01);
  const Radiation::Drift first = drift_at(2.0), second = drift_at(2.5);
  const BodyState state = at_depth(0);
  for (const double time_s : {0.0, 1.3, 7.9}) {
    const auto phase = [&](const WaveComponent& wave) {
      const double number = wave_number_rad_m(wave.angular_frequency_rad_s, 200, water.gravity_m_s2);
      return number * state.world_from_body.position_m.x() - wave.angular_frequency_rad_s * time_s + wave.phase_rad;
    };
    const double beat = std::cos(phase(two[0]) - phase(two[1]));
    const Vector6d expected = only_slow(4e-6 * first + 9e-6 * second + 6e-6 * beat * (first + second));
    const Vector6d got = waves.wrenches_at(state, water, time_s).diffraction;
    EXPECT_LT((got - expected).norm(), 1e-9 * expected.norm()) << time_s;
  }
}

TEST(HullWaves, TheDriftFadesContinuouslyAsTheHullDives) {
  const Water water = water_with(small_sea());
  const HullWaves waves("box", drifting_box(), water, 0.01);
  const auto force = [&](double depth_m) { return waves.wrenches_at(at_depth(depth_m), water, 0.7).diffraction; };
  const double afloat = force(0).norm();
  ASSERT_GT(afloat, 0);
  double last = afloat;
  for (double depth_m = 0; depth_m < 1.5; depth_m += 0.005) {
    const double now = force(depth_m).norm();
    EXPECT_LE(now, last + 1e-9 * afloat) << depth_m;
    EXPECT_LT(last - now, 0.02 * afloat) << depth_m;
    last = now;
  }
  EXPECT_EQ(last, 0) << "its top is half its length below the surface at 1.25 m";
}

/// Nor do tables without drift have a slow force.
TEST(HullWaves, WithoutDriftNothingIsAdded) {
  const std::shared_ptr<const Craft> box = drifting_box();
  CraftParameters bare = box->parameters();
  auto table = std::make_shared<Radiation>(*bare.radiation);
  table->drift.clear();
  bare.radiation = table;
  const auto without = craft_of(bare, testing::box(2, 1, 0.5));
  const Water water = water_with(small_sea());
  EXPECT_EQ(HullWaves("box", without, water, 0.01).wrenches_at(at_depth(0), water, 0.7).diffraction, Vector6d::Zero());
}

}  // namespace
}  // namespace uwsim
