#include "uwsim/world/sea_water.h"

#include <gtest/gtest.h>

#include <cmath>

#include "uwsim/core/check.h"
#include "uwsim/world/water.h"

namespace uwsim {
namespace {

TEST(SeaWater, HasTheDensitiesOfTheUnescoTable) {  // Fofonoff and Millard 1983, p = 0 and 1000 bar
  EXPECT_NEAR(sea_water_density_kg_m3(5, 0), 999.96675, 1e-5);
  EXPECT_NEAR(sea_water_density_kg_m3(5, 35), 1027.67547, 1e-5);
  EXPECT_NEAR(sea_water_density_kg_m3(25, 0), 997.04796, 1e-5);
  EXPECT_NEAR(sea_water_density_kg_m3(25, 35), 1023.34306, 1e-5);
  EXPECT_NEAR(sea_water_density_kg_m3(5, 0, 1e8), 1044.12802, 1e-5);
  EXPECT_NEAR(sea_water_density_kg_m3(5, 35, 1e8), 1069.48914, 1e-5);
  EXPECT_NEAR(sea_water_density_kg_m3(25, 0, 1e8), 1037.90204, 1e-5);
  EXPECT_NEAR(sea_water_density_kg_m3(25, 35, 1e8), 1062.53817, 1e-5);
  EXPECT_NEAR(sea_water_density_kg_m3(40, 40, 1e8), 1059.82037, 1e-5);
}

/// According to Saunders 1981 (UNESCO 44's check value), 10000 dbar are 9712.653 m deep at 30 degrees of latitude in
/// the standard ocean of 0 deg C and 35 psu, where gravity is 9.79324 m/s^2 at the surface, and grows with depth. At
/// half the pressure, the depth is 4908.560 m.
TEST(SeaWater, PressureGrowsWithDepthAsInTheUnescoTable) {
  Water ocean;
  ocean.gravity_m_s2 = 9.79324;
  ocean.surface_temperature_deg_c = ocean.bottom_temperature_deg_c = 0;
  ocean.salinity_psu = 35;
  ocean.density_kg_m3 = sea_water_density_kg_m3(0, 35);
  EXPECT_NEAR(ocean.pressure_pa(-9712.653) - ocean.atmospheric_pressure_pa, 1e8, 5e3);
  EXPECT_NEAR(ocean.pressure_pa(-4908.560) - ocean.atmospheric_pressure_pa, 5e7, 5e3);
}

/// Gravity grows by 2.26e-7 of itself a metre (TEOS-10).
TEST(SeaWater, PressureIsTheWeightOfTheCompressedColumn) {
  Water water;
  water.surface_temperature_deg_c = 20;
  water.bottom_temperature_deg_c = 4;
  water.bottom_depth_m = 1000;
  const auto gauge = [&](double depth) { return water.pressure_pa(-depth) - water.atmospheric_pressure_pa; };
  constexpr double kStep_m = 0.5;
  double weight_pa = 0;
  for (double depth = kStep_m / 2; depth < 1000; depth += kStep_m) {
    const double modulus = sea_water_bulk_modulus_pa(water.temperature_deg_c(-depth), 0, weight_pa);
    const double gravity = water.gravity() * (1 + 2.26e-7 * depth);
    weight_pa += kStep_m * gravity * water.density_kg_m3 / (1 - weight_pa / modulus);
  }
  EXPECT_NEAR(gauge(1000), weight_pa, 0.01 * 9806.65) << "1 cm of water";
  EXPECT_NEAR(gauge(1000) / 9806.65 - 1000, 2.45, 0.05) << "what a depth sensor without compression reads too much";
  water.compressible = false;
  EXPECT_DOUBLE_EQ(gauge(1000), 9806650);
}

TEST(SeaWater, InvalidArgumentsAreRefused) {
  for (const double bad : {-3.0, std::nan(""), 1e9}) {
    EXPECT_THROW(sea_water_density_kg_m3(bad, 35), InvalidValue);
    EXPECT_THROW(sea_water_density_kg_m3(10, bad), InvalidValue);
    EXPECT_THROW(sea_water_density_kg_m3(10, 35, bad), InvalidValue);
  }
}

}  // namespace
}  // namespace uwsim
