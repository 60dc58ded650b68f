#include "uwsim/acoustics/sonar_equation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "uwsim/acoustics/absorption_column.h"
#include "uwsim/core/check.h"
#include "uwsim/core/random.h"

namespace uwsim {
namespace {

constexpr double kSoundSpeed = 1450;

double fall_db(const BottomMaterial& bottom, double from_m, double to_m, double absorption_db_m = 0) {
  const SonarFigures sonar;
  return nadir_snr_db(sonar, bottom, from_m, kSoundSpeed, absorption_db_m) -
         nadir_snr_db(sonar, bottom, to_m, kSoundSpeed, absorption_db_m);
}

TEST(SonarEquation, ASmoothBottomFallsBy20LogRAndARoughOneBy30) {
  EXPECT_NEAR(fall_db({-30, 0}, 100, 1000), 20, 1e-9);
  EXPECT_NEAR(fall_db({-30, 2}, 1e3, 1e4), 30, 0.01);
}

TEST(SonarEquation, AbsorptionAppliesTwice) {
  EXPECT_NEAR(fall_db({-30, 0}, 100, 400, 0.05) - fall_db({-30, 0}, 100, 400, 0), 2 * 0.05 * 300, 1e-9);
}

TEST(SonarEquation, EachTermCountsOnce) {
  SonarFigures sonar;
  const double before = nadir_snr_db(sonar, {}, 50, kSoundSpeed, 0.02);
  sonar.source_level_db += 3;
  sonar.directivity_index_db += 4;
  sonar.noise_level_db -= 5;
  EXPECT_NEAR(nadir_snr_db(sonar, {-28, 0.1}, 50, kSoundSpeed, 0.02) - before, 3 + 4 + 5 + 2, 1e-9);
  sonar.pulse_length_s *= 10;
  EXPECT_NEAR(nadir_snr_db(sonar, {-28, 0.1}, 50, kSoundSpeed, 0.02) - before, 14 + 10, 1e-9);
}

TEST(SonarEquation, TheDetectionProbabilityIsOneHalfAtTheThresholdAndFallsWithRange) {
  for (const double looks : {1.0, 3.0, 30.0}) {
    EXPECT_NEAR(detection_probability(std::pow(10, 1.3), looks, 13), 0.5, 1e-12);
    double before = 1;
    for (double range = 1; range < 3000; range *= 1.1) {
      const double snr_db = nadir_snr_db({}, {}, range, kSoundSpeed, 0.05);
      const double now = detection_probability(std::pow(10, snr_db / 10), looks, 13);
      EXPECT_LE(now, before);
      before = now;
    }
    EXPECT_LT(before, 1e-3);
  }
}

TEST(SonarEquation, FadingHasTheMeanAndVarianceOfItsLooks) {
  const RandomStream stream(3, "fading");
  for (const double looks : {1.0, 4.0, 20.0}) {
    double sum = 0, squares = 0;
    constexpr int kDraws = 200'000;
    for (int k = 0; k < kDraws; ++k) {
      const double drawn = fading_intensity(9, looks, stream.normal(static_cast<std::uint64_t>(k)));
      sum += drawn;
      squares += drawn * drawn;
    }
    const double mean = sum / kDraws, variance = squares / kDraws - mean * mean;
    EXPECT_NEAR(mean, 10, 0.15);
    EXPECT_NEAR(variance * looks / 100, 1, looks < 2 ? 0.15 : 0.05) << looks << " looks";
  }
}

TEST(SonarEquation, RangeErrorsFallWithSignalAndBandwidthAndByPhaseForLongEchoes) {
  EXPECT_GT(amplitude_range_std_m(1, 0.03, 2), amplitude_range_std_m(1, 0.03, 20));
  EXPECT_GT(phase_range_std_m(1, 0.03, 2), phase_range_std_m(1, 0.03, 20));
  EXPECT_GT(phase_range_std_m(1, 0.06, 20), phase_range_std_m(1, 0.03, 20));
  EXPECT_NEAR(amplitude_range_std_m(0.03, 0.03, 1e9), 0.03 / std::sqrt(12.0), 1e-9) << "within one cell";
  EXPECT_LT(phase_range_std_m(1, 0.03, 100), 0.2 * amplitude_range_std_m(1, 0.03, 100));
  EXPECT_NEAR(phase_range_std_m(1, 0.01, 20) / phase_range_std_m(1, 0.04, 20), 0.5, 1e-12) << "four times the looks";
}

TEST(SonarEquation, RefusesFiguresOutOfRange) {
  for (double SonarFigures::*field :
       {&SonarFigures::frequency_hz, &SonarFigures::beam_width_along_rad, &SonarFigures::beam_width_across_rad,
        &SonarFigures::pulse_length_s, &SonarFigures::bandwidth_hz, &SonarFigures::source_level_db,
        &SonarFigures::directivity_index_db}) {
    for (const double bad : {-1.0, std::nan("")}) {
      SonarFigures sonar;
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
