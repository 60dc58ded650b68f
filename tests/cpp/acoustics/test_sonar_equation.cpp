#include "uwsim/acoustics/sonar_equation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "uwsim/acoustics/absorption_column.h"
#include "uwsim/core/check.h"

namespace uwsim {
namespace {

constexpr double kSoundSpeed = 1450;

double fall_db(const BottomMaterial& bottom, double from_m, double to_m, double absorption_db_m = 0) {
  const SonarParameters sonar;
  return echo_snr_db(sonar, bottom, {from_m}, kSoundSpeed, absorption_db_m) -
         echo_snr_db(sonar, bottom, {to_m}, kSoundSpeed, absorption_db_m);
}

TEST(SonarEquation, ASmoothBottomFallsBy20LogRAndARoughOneBy30) {
  EXPECT_NEAR(fall_db({-30, 0}, 100, 1000), 20, 1e-9);
  EXPECT_NEAR(fall_db({-30, 2}, 1e3, 1e4), 30, 0.01);
}

TEST(SonarEquation, AbsorptionAppliesTwice) {
  EXPECT_NEAR(fall_db({-30, 0}, 100, 400, 0.05) - fall_db({-30, 0}, 100, 400, 0), 2 * 0.05 * 300, 1e-9);
}

TEST(SonarEquation, EachTermCountsOnce) {
  SonarParameters sonar;
  const double before = echo_snr_db(sonar, {}, {50}, kSoundSpeed, 0.02);
  sonar.source_level_db += 3;
  sonar.directivity_index_db += 4;
  sonar.noise_level_db -= 5;
  EXPECT_NEAR(echo_snr_db(sonar, {-28, 0.1}, {50}, kSoundSpeed, 0.02) - before, 3 + 4 + 5 + 2, 1e-9);
  sonar.pulse_length_s *= 10;
  EXPECT_NEAR(echo_snr_db(sonar, {-28, 0.1}, {50}, kSoundSpeed, 0.02) - before, 14 + 10, 1e-9);
}

TEST(SonarEquation, AnObliqueEchoIsSpreadBySlopeAndLosesByLambertsLaw) {
  const SonarParameters sonar;
  const BottomMaterial rock{-30, 0.1};
  const double cell = sonar.range_cell_m(kSoundSpeed), slope = 200 * sonar.beam_width_across_rad;
  EXPECT_NEAR(echo_extent_m(sonar, {-30, 0}, {200}, kSoundSpeed), cell, 1e-12);
  const double gaussian = std::sqrt(std::numbers::pi / (4 * std::numbers::ln2));
  EXPECT_NEAR(echo_extent_m(sonar, {-30, 0}, {200, 1.1}, kSoundSpeed),
              std::hypot(cell, gaussian * slope * std::tan(1.1)), 1e-9);
  // A wide echo of the same plane: the area in a cell is R x width along x cell / sin i.
  const double area = echo_area_m2(sonar, {-30, 0}, {200, 1.1}, kSoundSpeed);
  EXPECT_NEAR(area, gaussian * 200 * sonar.beam_width_along_rad * cell / std::sin(1.1), 0.01 * area);
  const double lambert = echo_snr_db(sonar, rock, {200, 1.1}, kSoundSpeed, 0) -
                         10 * std::log10(echo_area_m2(sonar, rock, {200, 1.1}, kSoundSpeed)) -
                         echo_snr_db(sonar, rock, {200}, kSoundSpeed, 0) +
                         10 * std::log10(echo_area_m2(sonar, rock, {200}, kSoundSpeed));
  EXPECT_NEAR(lambert, 20 * std::log10(std::cos(1.1)), 1e-9);
}

TEST(SonarEquation, AFlatArrayHasItsProjectedLength) {
  EXPECT_EQ(steered_widening(0), 1);
  EXPECT_NEAR(steered_widening(std::numbers::pi / 3), 2, 1e-12);
  EXPECT_EQ(steered_widening(3), steered_widening(80 * std::numbers::pi / 180)) << "no wider beyond 80 degrees";
}

TEST(SonarEquation, ASteeredArrayLosesDirectivityAsItsBeamWidens) {
  const double tilt = std::numbers::pi / 3;
  const SonarParameters sonar;
  const BottomMaterial smooth{-30, 0};
  const auto steered_db = [&](double incidence_rad) {
    return echo_snr_db(sonar, smooth, {200, incidence_rad, tilt}, kSoundSpeed, 0) -
           echo_snr_db(sonar, smooth, {200, incidence_rad}, kSoundSpeed, 0);
  };
  EXPECT_NEAR(steered_db(0), 0, 1e-9) << "straight down, the footprint grows as much as the noise";
  EXPECT_NEAR(steered_db(1.2), -10 * std::log10(2), 0.01) << "aslant, the range cell bounds the footprint";
}

TEST(SonarEquation, RefusesParametersOutOfRange) {
  for (double SonarParameters::*field :
       {&SonarParameters::frequency_hz, &SonarParameters::beam_width_along_rad, &SonarParameters::beam_width_across_rad,
        &SonarParameters::pulse_length_s, &SonarParameters::bandwidth_hz, &SonarParameters::source_level_db,
        &SonarParameters::directivity_index_db}) {
    for (const double bad : {-1.0, std::nan("")}) {
      SonarParameters sonar;
      sonar.*field = bad;
      EXPECT_THROW(sonar.check(), InvalidValue);
    }
  }
}

TEST(AbsorptionColumn, TheMeanAlongAPathIsTheMeanOverItsDepths) {
  const AbsorptionColumn column([](double depth) { return 50 + 0.1 * depth; }, 1000);
  EXPECT_NEAR(column.mean_db_m(100, 300), (50 + 20) / 1000.0, 1e-9);
  EXPECT_NEAR(column.mean_db_m(300, 100), (50 + 20) / 1000.0, 1e-9);
  EXPECT_NEAR(column.mean_db_m(200, 200), (50 + 20) / 1000.0, 1e-9);
  EXPECT_NEAR(column.mean_db_m(1000, 3000), 0.25, 1e-9) << "below the bottom, too";
  EXPECT_NEAR(column.mean_db_m(0, 2000), 0.15, 1e-9);
  EXPECT_NEAR(column.mean_db_m(400, 11000), 0.62, 1e-9) << "down to the deepest bed";
  EXPECT_NEAR(column.at_db_m(13000), 1.25, 1e-9) << "and constant there";
}

}  // namespace
}  // namespace uwsim
