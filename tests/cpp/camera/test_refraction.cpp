#include "uwsim/camera/refraction.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "uwsim/camera/daylight.h"

namespace uwsim {
namespace {

TEST(Refraction, FollowsSnellAndConservesEnergy) {
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  for (double degrees = 0; degrees < 90; degrees += 7) {
    const double angle = degrees * std::numbers::pi / 180;
    const auto below = refracted({std::sin(angle), 0, -std::cos(angle)}, up, 1, 1.333);
    ASSERT_TRUE(below);
    EXPECT_NEAR(below->norm(), 1, 1e-12);
    EXPECT_NEAR(1.333 * below->x(), std::sin(angle), 1e-12);
    const double inside = -below->z();  // the reverse direction loses the same fraction
    EXPECT_NEAR(fresnel_reflectance(std::cos(angle), 1, 1.333), fresnel_reflectance(inside, 1.333, 1), 1e-9);
  }
  EXPECT_FALSE(refracted({std::sin(0.9), 0, std::cos(0.9)}, -up, 1.333, 1));
  EXPECT_EQ(fresnel_reflectance(std::cos(0.9), 1.333, 1), 1);
}

TEST(Refraction, AnEvenSkyLosesTheIntegralOfFresnelsReflectance) {
  constexpr int kSteps = 100'000;
  double reflected = 0;
  for (int k = 0; k < kSteps; ++k) {
    const double cosine = (k + 0.5) / kSteps;
    reflected += 2 * cosine * fresnel_reflectance(cosine, 1, kWaterIndex) / kSteps;
  }
  const DaylightBelow below = daylight_below({Eigen::Vector3d::UnitZ(), Bands::Zero(), Bands::Ones()}, kWaterIndex);
  EXPECT_NEAR(below.sky_level.minCoeff(), 1 - reflected, 5e-4);
  EXPECT_NEAR(below.sky_level.maxCoeff(), 1 - reflected, 5e-4);
}

}  // namespace
}  // namespace uwsim
