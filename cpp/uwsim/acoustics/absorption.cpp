#include "uwsim/acoustics/absorption.h"

#include <cmath>

#include "uwsim/core/check.h"
#include "uwsim/core/with_unit.h"

namespace uwsim {
namespace {

/// The contribution of one relaxing compound: A P f_r f^2 / (f_r^2 + f^2).
double relaxation(double amplitude, double relaxation_khz, double frequency_khz) {
  if (relaxation_khz == 0) return 0;  // fresh water
  const double f2 = frequency_khz * frequency_khz;
  return amplitude * relaxation_khz * f2 / (relaxation_khz * relaxation_khz + f2);
}

}  // namespace

double absorption_db_km(double frequency_hz, double t, double s, double d, double acidity_ph) {
  require(frequency_hz > 0 && frequency_hz <= 1e7, "frequency_hz", frequency_hz, "Hz: must be in (0, 1e7] Hz");
  require(t >= -2 && t <= 40, "temperature_deg_c", t, "deg C: must be in [-2, 40] deg C");
  require(s >= 0 && s <= 45, "salinity_psu", s, "psu: must be in [0, 45] psu");
  require(d >= 0 && d <= 12000, "depth_m", with_unit(d, "m"), "must be in [0, 12000] m");
  require(acidity_ph >= 6 && acidity_ph <= 9, "acidity_ph", acidity_ph, "must be in [6, 9]");
  const double f = frequency_hz / 1000;
  const double theta = 273 + t;
  const double c = 1412 + 3.21 * t + 1.19 * s + 0.0167 * d;
  const double boric = 8.86 / c * std::pow(10, 0.78 * acidity_ph - 5);
  const double boric_khz = 2.8 * std::sqrt(s / 35) * std::pow(10, 4 - 1245 / theta);
  const double sulphate = 21.44 * s / c * (1 + 0.025 * t) * (1 - 1.37e-4 * d + 6.2e-9 * d * d);
  const double sulphate_khz = 8.17 * std::pow(10, 8 - 1990 / theta) / (1 + 0.0018 * (s - 35));
  const double pure = t <= 20 ? 4.937e-4 - 2.59e-5 * t + 9.11e-7 * t * t - 1.50e-8 * t * t * t
                              : 3.964e-4 - 1.146e-5 * t + 1.45e-7 * t * t - 6.5e-10 * t * t * t;
  const double pure_pressure = 1 - 3.83e-5 * d + 4.9e-10 * d * d;
  return relaxation(boric, boric_khz, f) + relaxation(sulphate, sulphate_khz, f) + pure * pure_pressure * f * f;
}

}  // namespace uwsim
