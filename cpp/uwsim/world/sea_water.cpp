#include "uwsim/world/sea_water.h"

#include <cmath>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

void check(double t, double s, double gauge_pressure_pa) {
  require(t >= -2 && t <= 40, "temperature_deg_c", t, "deg C: must be in [-2, 40] deg C");
  require(s >= 0 && s <= 45, "salinity_psu", s, "psu: must be in [0, 45] psu");
  require(gauge_pressure_pa >= 0 && gauge_pressure_pa <= 2e8, "gauge_pressure_pa", gauge_pressure_pa,
          "Pa: must be in [0, 2e8] Pa");
}

}  // namespace

double sea_water_density_kg_m3(double t, double s) {
  check(t, s, 0);
  const double water =
      999.842594 + t * (6.793952e-2 + t * (-9.095290e-3 + t * (1.001685e-4 + t * (-1.120083e-6 + t * 6.536332e-9))));
  const double a = 8.24493e-1 + t * (-4.0899e-3 + t * (7.6438e-5 + t * (-8.2467e-7 + t * 5.3875e-9)));
  const double b = -5.72466e-3 + t * (1.0227e-4 - t * 1.6546e-6);
  return water + s * (a + b * std::sqrt(s) + 4.8314e-4 * s);
}

double sea_water_bulk_modulus_pa(double t, double s, double gauge_pressure_pa) {
  check(t, s, gauge_pressure_pa);
  const double p = gauge_pressure_pa / 1e5;  // in bar
  const double root = std::sqrt(s);
  const double water = 19652.21 + t * (148.4206 + t * (-2.327105 + t * (1.360477e-2 - t * 5.155288e-5)));
  const double salt = 54.6746 + t * (-0.603459 + t * (1.09987e-2 - t * 6.1670e-5));
  const double salt_root = 7.944e-2 + t * (1.6483e-2 - t * 5.3009e-4);
  const double a = 3.239908 + t * (1.43713e-3 + t * (1.16092e-4 - t * 5.77905e-7)) +
                   s * (2.2838e-3 + t * (-1.0981e-5 - t * 1.6078e-6) + 1.91075e-4 * root);
  const double b = 8.50935e-5 + t * (-6.12293e-6 + t * 5.2787e-8) + s * (-9.9348e-7 + t * (2.0816e-8 + t * 9.1697e-10));
  return 1e5 * (water + s * (salt + salt_root * root) + p * (a + p * b));
}

double sea_water_density_kg_m3(double t, double s, double gauge_pressure_pa) {
  return sea_water_density_kg_m3(t, s) / (1 - gauge_pressure_pa / sea_water_bulk_modulus_pa(t, s, gauge_pressure_pa));
}

double compressed_pressure_pa(double uncompressed_pa, double t, double s) {
  double pressure = uncompressed_pa;
  for (int pass = 0; pass < 2; ++pass) {
    const double modulus = sea_water_bulk_modulus_pa(t, s, 2.0 / 3 * pressure);
    pressure = 2 * uncompressed_pa / (1 + std::sqrt(1 - 2 * uncompressed_pa / modulus));
  }
  return pressure;
}

}  // namespace uwsim
