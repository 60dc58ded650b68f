#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>

#include "uwsim/world/water.h"
#include "world/wave_constants.h"

namespace uwsim {
namespace {

struct Regular {  // an eastward wave on deep water
  double amplitude_m, period_s;

  double omega() const { return 2 * kPi / period_s; }
  double number() const { return omega() * omega() / kGravity; }
  Water water() const {
    const WaveComponent wave{amplitude_m, omega(), 0, 0.7};
    Water deep;
    deep.waves = std::make_shared<const Waves>(std::span(&wave, 1), 1000);
    return deep;
  }
};

/// The mean velocity of a water particle over many periods, between its mean positions in the first and the last one.
Eigen::Vector3d drift_m_s(const Water& water, Eigen::Vector3d place, double period_s, int periods) {
  constexpr int kSteps = 100;  // per period
  const double h = period_s / kSteps;
  const auto velocity = [&](const Eigen::Vector3d& at, double t) { return water.flow_at(at, t).velocity_m_s; };
  Eigen::Vector3d first = Eigen::Vector3d::Zero(), last = first;
  for (int k = 0; k < periods * kSteps; ++k) {
    if (k < kSteps) first += place / kSteps;
    if (k >= (periods - 1) * kSteps) last += place / kSteps;
    const double t = k * h;
    const Eigen::Vector3d a = velocity(place, t), b = velocity(place + h / 2 * a, t + h / 2),
                          c = velocity(place + h / 2 * b, t + h / 2), d = velocity(place + h * c, t + h);
    place += h / 6 * (a + 2 * b + 2 * c + d);
  }
  return (last - first) / ((periods - 1) * period_s);
}

TEST(WaveDrift, BelowTheTroughsTheOrbitalVelocityIsThatOfLinearTheory) {
  const Regular wave{0.5, 5};
  const Water water = wave.water();
  for (const double z : {-1.01, -3.0, -10.0, -28.0}) {
    const double expected = wave.amplitude_m * wave.omega() * std::exp(wave.number() * z);
    for (double t = 0; t < 5; t += 0.31) {
      EXPECT_NEAR(water.flow_at({3, 1, z}, t).velocity_m_s.norm(), expected, 1e-12) << z;
    }
  }
}

/// Stokes 1847: a^2 omega k exp(2 k z), to second order, along the wave and without a vertical component.
TEST(WaveDrift, ParticlesDriftAsStokesSays) {
  const Regular wave{0.1, 4};
  const Water water = wave.water();
  const double at_surface = wave.amplitude_m * wave.amplitude_m * wave.omega() * wave.number();
  for (const double z : {-0.25, -1.0, -5.0, -15.0}) {
    const double expected = at_surface * std::exp(2 * wave.number() * z);
    const Eigen::Vector3d drift = drift_m_s(water, {0, 0, z}, 4, 30);
    EXPECT_NEAR(drift.x(), expected, 0.05 * expected) << z;
    EXPECT_LT(std::abs(drift.z()), 0.02 * expected) << z;
  }
}

TEST(WaveDrift, UnderTheSurfaceParticlesDriftWithTheWaveAndNeitherRiseNorSink) {
  const Regular wave{0.1, 4};
  const double at_surface = wave.amplitude_m * wave.amplitude_m * wave.omega() * wave.number();
  for (const double z : {-0.02, -0.06, -0.1, -0.15}) {
    const Eigen::Vector3d drift = drift_m_s(wave.water(), {0, 0, z}, 4, 30);
    EXPECT_GT(drift.x(), 0.3 * at_surface) << z;
    EXPECT_LT(std::abs(drift.z()), 0.1 * at_surface) << z;
  }
}

TEST(WaveDrift, TheAccelerationIsThatOfAParticleAtEveryDepthAndInACurrent) {
  Water water;
  water.waves = std::make_shared<const Waves>(
      Waves::jonswap({.significant_height_m = 0.8, .peak_period_s = 4, .spreading_exponent = 3, .seed = 5}, 30));
  water.current_world_m_s = {0.4, -0.2, 0.05};
  constexpr double kStep_s = 1e-4;
  for (const double under_m : {0.01, 0.1, 0.3, 0.6, 2.0, 9.0}) {
    for (double t = 3; t < 40; t += 4.1) {
      const Eigen::Vector3d p(2, 1, water.surface_height_at(2, 1, t) - under_m);
      const WaterFlow here = water.flow_at(p, t);
      const auto later = [&](double s) { return water.flow_at(p + s * here.velocity_m_s, t + s).velocity_m_s; };
      const Eigen::Vector3d rate = (later(kStep_s) - later(-kStep_s)) / (2 * kStep_s);
      EXPECT_LT((here.wave_acceleration_m_s2 - rate).norm(), 1e-5) << under_m << " " << t;
    }
  }
}

/// Longuet-Higgins and Stewart 1964: the mean vertical flux of momentum carries part of the weight of the water.
TEST(WaveDrift, TheMeanPressureIsHydrostaticLessTheFluxOfVerticalMomentum) {
  const Regular wave{0.4, 5};
  Water water = wave.water();
  water.compressible = false;
  constexpr int kSamples = 400;
  for (const double z : {-1.0, -4.0, -12.0}) {
    double pressure = 0, flux = 0;
    for (int k = 0; k < kSamples; ++k) {
      const double t = 5.0 * k / kSamples;
      pressure += water.gauge_pressure_at({1, 2, z}, t) / kSamples;
      flux += 1000 * std::pow(water.flow_at({1, 2, z}, t).velocity_m_s.z(), 2) / kSamples;
    }
    EXPECT_GT(flux, 1);
    EXPECT_NEAR(pressure + 1000 * kGravity * z, -flux, 1e-6) << z;
  }
}

}  // namespace
}  // namespace uwsim
