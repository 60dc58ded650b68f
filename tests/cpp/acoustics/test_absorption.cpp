#include "uwsim/acoustics/absorption.h"

#include <gtest/gtest.h>

#include <cmath>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

TEST(Absorption, AgreesWithFrancoisAndGarrisonsTable) {
  EXPECT_NEAR(absorption_db_km(100e3, 10, 35, 50), 33.4, 0.1);
  EXPECT_NEAR(absorption_db_km(200e3, 10, 35, 50), 54.1, 0.1);
  EXPECT_NEAR(absorption_db_km(300e3, 10, 35, 50), 72.8, 0.1);
}

TEST(Absorption, InFreshWaterGrowsWithTheSquareOfTheFrequency) {
  EXPECT_NEAR(absorption_db_km(600e3, 10, 0, 10) / absorption_db_km(300e3, 10, 0, 10), 4, 1e-9);
}

TEST(Absorption, InvalidArgumentsAreRefused) {
  for (const double bad : {-3.0, std::nan(""), 1e9}) {
    EXPECT_THROW(absorption_db_km(bad, 10, 35, 50), InvalidValue);
    EXPECT_THROW(absorption_db_km(3e5, bad, 35, 50), InvalidValue);
    EXPECT_THROW(absorption_db_km(3e5, 10, bad, 50), InvalidValue);
    EXPECT_THROW(absorption_db_km(3e5, 10, 35, bad), InvalidValue);
    EXPECT_THROW(absorption_db_km(3e5, 10, 35, 50, bad), InvalidValue);
  }
}

}  // namespace
}  // namespace uwsim
