#include "uwsim/world/sediment.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

SedimentCloud cloud() {
  SedimentCloud cloud;
  cloud.middle_m = {1, -2, -10};
  cloud.across_m = 0.6;
  cloud.up_m = 0.2;
  cloud.mass_kg = 0.3;
  return cloud;
}

double concentration(const SedimentCloud& of, const Eigen::Vector3d& at) {
  const Eigen::Vector3d off = at - of.middle_m;
  const double q = off.head<2>().squaredNorm() / (of.across_m * of.across_m) + off.z() * off.z() / (of.up_m * of.up_m);
  return 2 * of.mass_kg / (std::pow(2 * std::numbers::pi, 1.5) * of.across_m * of.across_m * of.up_m) *
         std::exp(-q / 2);
}

TEST(SedimentCloud, AColumnIsTheIntegralOfTheConcentration) {
  const Eigen::Vector3d origin(-0.5, -1.2, -9.3);
  for (const Eigen::Vector3d& target : {Eigen::Vector3d(1.2, -2, -9.9), {3, -3, -9.5}, {0, -1.4, -9.4}}) {
    const double length_m = (target - origin).norm();
    const Eigen::Vector3d direction = (target - origin) / length_m;
    constexpr int kParts = 20000;
    double sum = 0;
    for (int k = 0; k < kParts; ++k)
      sum += concentration(cloud(), origin + (k + 0.5) / kParts * length_m * direction) * length_m / kParts;
    EXPECT_NEAR(cloud().column_kg_m2(origin, direction, length_m), sum, 1e-6 * sum + 1e-12);
  }
}

TEST(SedimentCloud, AllOfItsMassIsAboveTheBed) {
  double mass_kg = 0;
  const double step_m = 0.1;
  for (double x = -3; x < 5; x += step_m) {
    for (double y = -6; y < 2; y += step_m)
      mass_kg += cloud().column_kg_m2({x, y, -5}, -Eigen::Vector3d::UnitZ(), 5) * step_m * step_m;
  }
  EXPECT_NEAR(mass_kg, cloud().mass_kg, 1e-3 * cloud().mass_kg);
}

TEST(SedimentCloud, SpreadsByDiffusionAndSettlesHoweverTheTimeIsDivided) {
  const Sediment sediment;
  SedimentCloud once = cloud(), often = cloud();
  once.advance(sediment, 60);
  for (int k = 0; k < 120; ++k) often.advance(sediment, 0.5);
  EXPECT_NEAR(once.across_m, std::sqrt(0.36 + 2 * sediment.mixing_m2_s * 60), 1e-12);
  EXPECT_NEAR(often.up_m, once.up_m, 1e-12);
  EXPECT_NEAR(often.mass_kg, once.mass_kg, 1e-12);
  // The share that settles at first: the concentration at the bed times the speed of the grains.
  SedimentCloud soon = cloud();
  soon.advance(sediment, 1e-3);
  const double at_bed = 2 / (std::sqrt(2 * std::numbers::pi) * 0.2);
  EXPECT_NEAR((1 - soon.mass_kg / 0.3) / 1e-3, sediment.settling_m_s() * at_bed,
              1e-4 * sediment.settling_m_s() * at_bed);
}

TEST(SedimentCloud, TwoThatJoinKeepMassCentreAndWidth) {
  SedimentCloud other = cloud(), both = cloud();
  other.middle_m += Eigen::Vector3d(0.8, 0, 0);
  other.mass_kg = 0.1;
  other.across_m = 0.3;
  both.add(other);
  EXPECT_NEAR(both.mass_kg, 0.4, 1e-15);
  EXPECT_NEAR(both.middle_m.x(), 1 + 0.25 * 0.8, 1e-12);
  // Second moments along x and y about the new centre, summed
  const double apart = 0.75 * 0.25 * 0.64;
  EXPECT_NEAR(2 * both.across_m * both.across_m, 2 * (0.75 * 0.36 + 0.25 * 0.09) + apart, 1e-12);
}

TEST(Sediment, FineGrainsSinkByStokesLaw) {
  Sediment silt;
  for (const double grain_m : {2e-6, 10e-6, 30e-6}) {
    silt.grain_m = grain_m;
    const double stokes = 1.65 * 9.80665 * grain_m * grain_m / 18e-6;
    EXPECT_NEAR(silt.settling_m_s(), stokes, 0.1 * stokes);  // Soulsby's constant is fitted to sand
  }
  silt.grain_m = 1e-3;  // Hallermeier 1981, for natural sand: 1.05 D*^1.5 nu / d
  const double cubed = 1e-9 * 9.80665 * 1.65 / 1e-12;
  const double coarse = 1.05 * std::sqrt(cubed) * 1e-6 / 1e-3;
  EXPECT_NEAR(silt.settling_m_s(), coarse, 0.15 * coarse);
}

TEST(Sediment, GrainsScatterByRayleighWhenSmallAndByTheirSectionWhenLarge) {
  Sediment sand;
  const double ratio = sand.backscatter_m2_kg(2000) / sand.backscatter_m2_kg(1000);
  EXPECT_NEAR(ratio, 16, 0.5);  // with the fourth power of the frequency
  sand.grain_m = 2e-3;
  const double geometric = 3 / (16 * std::numbers::pi * 2650 * 1e-3);
  EXPECT_NEAR(sand.backscatter_m2_kg(5e4), geometric / 0.81, 0.02 * geometric);
}

TEST(Sediment, RefusesWhatIsNoSediment) {
  Sediment bad;
  bad.grain_m = 0.1;
  EXPECT_THROW(bad.check(), InvalidValue);
}

TEST(ImpingingJet, ExertsMostStressAtASeventhOfItsDistance) {
  const ImpingingJet jet{20, 1.5};
  EXPECT_NEAR(jet.largest_pa(), 0.204 * 20 / 2.25, 0.01);
  EXPECT_NEAR(jet.stress_pa(0.14 * 1.5), jet.largest_pa(), 0.01 * jet.largest_pa());
  EXPECT_LT(jet.stress_pa(0.01), 0.3 * jet.largest_pa());
  EXPECT_LT(jet.stress_pa(0.5), jet.stress_pa(0.3));
  for (const double stress_pa : {0.01, 0.1, 1.7})
    EXPECT_NEAR(jet.stress_pa(jet.radius_m(stress_pa)), stress_pa, 1e-3 * stress_pa);
  EXPECT_EQ(jet.radius_m(3), 0);
}

TEST(ImpingingJet, AWeakOneLiftsNothing) {
  const Sediment sediment;
  EXPECT_EQ((ImpingingJet{1, 1.5}.erosion_kg_s(sediment)), 0);
  // Far above the critical stress, twice the thrust lifts about twice as much within the same area, and reaches
  // farther.
  const double once = ImpingingJet{20, 1}.erosion_kg_s(sediment), twice = ImpingingJet{40, 1}.erosion_kg_s(sediment);
  EXPECT_GT(twice, 2 * once);
  EXPECT_LT(twice, 4 * once);
}

}  // namespace
}  // namespace uwsim
