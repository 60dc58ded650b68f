#include "uwsim/world/water_profile.h"

#include <gtest/gtest.h>

#include <cmath>

#include "uwsim/core/check.h"
#include "uwsim/world/water.h"

namespace uwsim {
namespace {

WaterLevel level(double depth_m, double density_kg_m3) { return {.depth_m = depth_m, .density_kg_m3 = density_kg_m3}; }

const std::vector<WaterLevel> kLevels = {level(2, 1000), level(6, 1008), level(20, 1010)};

TEST(WaterProfile, TheColumnsMassIsTheIntegralOfDensity) {
  const WaterProfile profile(kLevels);
  EXPECT_DOUBLE_EQ(profile.column_kg_m2(-1), 1000);
  EXPECT_DOUBLE_EQ(profile.column_kg_m2(-4), 2 * 1000 + 2 * 1002);
  EXPECT_DOUBLE_EQ(profile.column_kg_m2(-30), 2 * 1000 + 4 * 1004 + 14 * 1009 + 10 * 1010);
  EXPECT_DOUBLE_EQ(profile.column_kg_m2(0.5), -500);
  for (double z = -25; z < 1; z += 0.3) {
    const double slope = (profile.column_kg_m2(z - 1e-4) - profile.column_kg_m2(z + 1e-4)) / 2e-4;
    EXPECT_NEAR(slope, profile.at(z).density_kg_m3, 1e-6);
    const DensityLayer layer = profile.density_layer_at(z);
    EXPECT_LE(layer.low_m, z);
    EXPECT_LT(z, layer.high_m);
    EXPECT_NEAR(layer.at(z), profile.at(z).density_kg_m3, 1e-9);
  }
}

TEST(WaterProfile, PressureAndDensityOfTheWaterFollowTheProfile) {
  Water water;
  water.compressible = false;
  water.profile = std::make_shared<const WaterProfile>(kLevels);
  water.check();
  EXPECT_FALSE(water.calm_and_even());
  EXPECT_DOUBLE_EQ(water.pressure_pa(-4), 101325 + 9.80665 * 4004);
  EXPECT_DOUBLE_EQ(water.pressure_pa({1, 2, -4}, 9), 101325 + 9.80665 * 4004);
  EXPECT_DOUBLE_EQ(water.pressure_pa(3), 101325);
  EXPECT_DOUBLE_EQ(water.density_at(-4), 1004);
}

TEST(WaterProfile, EqualDensitiesMakeUniformWater) {
  Water water;
  water.profile = std::make_shared<const WaterProfile>(std::vector{level(0, 1020), level(9, 1020)});
  EXPECT_TRUE(water.calm_and_even());
  EXPECT_DOUBLE_EQ(water.density_at(-3), 1020);
}

TEST(WaterProfile, InvalidProfilesAreRefused) {
  EXPECT_THROW(WaterProfile({}), InvalidValue);
  EXPECT_THROW(WaterProfile(std::vector{level(3, 1000), level(3, 1001)}), InvalidValue);
  EXPECT_THROW(WaterProfile(std::vector{level(0, 10)}), InvalidValue);
  EXPECT_THROW(WaterProfile(std::vector{level(0, std::nan(""))}), InvalidValue);
}

}  // namespace
}  // namespace uwsim
