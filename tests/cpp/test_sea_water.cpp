#include "uwsim/acoustics/sea_water.h"

#include <gtest/gtest.h>

namespace uwsim {
namespace {

TEST(SoundSpeed, AgreesWithMackenziesOwnCheckValue) {
  EXPECT_NEAR(sound_speed_m_s(25, 35, 1000), 1550.744, 1e-3);  // Mackenzie 1981
}

TEST(Absorption, AgreesWithFrancoisAndGarrisonsTable) {
  EXPECT_NEAR(absorption_db_km(100e3, 10, 35, 50), 33.4, 0.1);
  EXPECT_NEAR(absorption_db_km(200e3, 10, 35, 50), 54.1, 0.1);
  EXPECT_NEAR(absorption_db_km(300e3, 10, 35, 50), 72.8, 0.1);
}

TEST(Absorption, InFreshWaterGrowsWithTheSquareOfTheFrequency) {
  EXPECT_NEAR(absorption_db_km(600e3, 10, 0, 10) / absorption_db_km(300e3, 10, 0, 10), 4, 1e-9);
}

}  // namespace
}  // namespace uwsim
