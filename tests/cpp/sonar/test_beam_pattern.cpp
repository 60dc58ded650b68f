#include "uwsim/sonar/imaging/beam_pattern.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

double db(double power) { return 10 * std::log10(power); }

/// The highest level outside the main lobe.
double side_lobe_db(const BeamPattern& pattern) {
  double angle = 0;
  while (pattern.power(angle + 1e-4) <= pattern.power(angle)) angle += 1e-4;
  double highest = 0;
  for (; angle < 1; angle += 1e-4) highest = std::max(highest, pattern.power(angle));
  return db(highest);
}

TEST(BeamPattern, FallsToHalfPowerAtHalfItsWidthForAnyTaper) {
  for (const double taper : {0.0, 0.25, 0.46, 0.5}) {
    for (const double width : {0.01, 0.3, 2.0}) {
      const BeamPattern pattern(width, taper, 0);
      EXPECT_DOUBLE_EQ(pattern.power(0), 1);
      EXPECT_NEAR(pattern.power(width / 2), 0.5, 1e-9);
      EXPECT_NEAR(pattern.power(-width / 2), 0.5, 1e-9);
    }
  }
}

TEST(BeamPattern, SideLobesAreThoseOfTheWindow) {
  EXPECT_NEAR(side_lobe_db({0.05, 0, 0}), -13.26, 0.02) << "no shading (Harris 1978, table 1: -13)";
  EXPECT_NEAR(side_lobe_db({0.05, 0.46, 0}), -42.7, 1) << "Hamming (ibid.: -43)";
}

TEST(BeamPattern, DoesNotFallBelowItsFloor) {
  const BeamPattern pattern(0.05, 0.46, 1e-3);
  for (double angle = -3; angle < 3; angle += 0.01) EXPECT_GE(pattern.power(angle), 1e-3);
  EXPECT_EQ(pattern.power(1.0), 1e-3);
}

TEST(BeamPattern, RefusesParametersOutOfRange) {
  EXPECT_THROW(BeamPattern(0, 0, 0), InvalidValue);
  EXPECT_THROW(BeamPattern(3.2, 0, 0), InvalidValue);
  EXPECT_THROW(BeamPattern(0.1, 0.51, 0), InvalidValue);
  EXPECT_THROW(BeamPattern(0.1, 0, 1), InvalidValue);
  EXPECT_THROW(BeamPattern(std::numeric_limits<double>::quiet_NaN(), 0, 0), InvalidValue);
}

}  // namespace
}  // namespace uwsim
