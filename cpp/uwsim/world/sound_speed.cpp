#include "uwsim/world/sound_speed.h"

#include <cmath>
#include <sstream>

#include "uwsim/core/check.h"
#include "uwsim/core/names.h"
#include "uwsim/core/with_unit.h"
#include "uwsim/world/sea_water.h"

namespace uwsim {
namespace {

constexpr double kStandardGravity_m_s2 = 9.80665;

/// c0 + c1 x + c2 x^2 + ...
template <typename... Rest>
double polynomial(double x, double c0, Rest... rest) {
  if constexpr (sizeof...(rest) == 0) {
    return c0;
  } else {
    return c0 + x * polynomial(x, rest...);
  }
}

double unesco(double t, double s, double p) {  // p in bar
  const double water = polynomial(p, polynomial(t, 1402.388, 5.03830, -5.81090e-2, 3.3432e-4, -1.47797e-6, 3.1419e-9),
                                  polynomial(t, 0.153563, 6.8999e-4, -8.1829e-6, 1.3632e-7, -6.1260e-10),
                                  polynomial(t, 3.1260e-5, -1.7111e-6, 2.5986e-8, -2.5353e-10, 1.0415e-12),
                                  polynomial(t, -9.7729e-9, 3.8513e-10, -2.3654e-12));
  const double a = polynomial(p, polynomial(t, 1.389, -1.262e-2, 7.166e-5, 2.008e-6, -3.21e-8),
                              polynomial(t, 9.4742e-5, -1.2583e-5, -6.4928e-8, 1.0515e-8, -2.0142e-10),
                              polynomial(t, -3.9064e-7, 9.1061e-9, -1.6009e-10, 7.994e-12),
                              polynomial(t, 1.100e-10, 6.651e-12, -3.391e-13));
  const double b = -1.922e-2 - 4.42e-5 * t + (7.3637e-5 + 1.7950e-7 * t) * p;
  const double d = 1.727e-3 - 7.9836e-6 * p;
  return water + s * (a + b * std::sqrt(s) + d * s);
}

double del_grosso(double t, double s, double p) {  // p in kg/cm^2
  const double apart = polynomial(t, 0, 5.012285, -5.51184e-2, 2.21649e-4) + s * (1.329530 + 1.288598e-4 * s) +
                       polynomial(p, 0, 0.1560592, 2.449993e-5, -8.833959e-9);
  const double together = t * p * (6.353509e-3 + p * (-1.593895e-6 + 5.222483e-10 * p) + 2.656174e-8 * t * p) -
                          4.383615e-7 * t * t * t * p + s * t * (-1.275936e-2 + 9.688441e-5 * t) -
                          1.616745e-9 * s * s * p * p + s * t * p * (4.857614e-6 * s - 3.406824e-4);
  return 1402.392 + apart + together;
}

double belogolskii(double t, double p) {  // p in MPa above atmospheric
  return polynomial(p,
                    polynomial(t, 1402.38744, 5.03836171, -5.81172916e-2, 3.34638117e-4, -1.48259672e-6, 3.16585020e-9),
                    polynomial(t, 1.49043589, 1.077850609e-2, -2.232794656e-4, 2.718246452e-6),
                    polynomial(t, 4.31532833e-3, -2.938590293e-4, 6.822485943e-6, -6.674551162e-8),
                    polynomial(t, -1.852993525e-5, 1.481844713e-6, -3.940994021e-8, 3.939902307e-10));
}

double leroy(double t, double s, double d) {
  return 1402.5 + 5 * t - 5.44e-2 * t * t + 2.1e-4 * t * t * t + 1.33 * s - 1.23e-2 * s * t + 8.7e-5 * s * t * t +
         1.56e-2 * d + 2.55e-7 * d * d - 7.3e-12 * d * d * d - 9.5e-13 * t * d * d * d + 3e-7 * t * t * d +
         1.43e-5 * s * d;
}

double mackenzie(double t, double s, double d) {
  return 1448.96 + 4.591 * t - 5.304e-2 * t * t + 2.374e-4 * t * t * t + 1.340 * (s - 35) + 1.630e-2 * d +
         1.675e-7 * d * d - 1.025e-2 * t * (s - 35) - 7.139e-13 * t * d * d * d;
}

double medwin(double t, double s, double d) {
  return 1449.2 + 4.6 * t - 5.5e-2 * t * t + 2.9e-4 * t * t * t + (1.34 - 0.010 * t) * (s - 35) + 0.016 * d;
}

}  // namespace

bool WaterRange::covers(const WaterRange& other) const {
  return coldest_deg_c <= other.coldest_deg_c && other.warmest_deg_c <= warmest_deg_c &&
         freshest_psu <= other.freshest_psu && other.saltiest_psu <= saltiest_psu && other.deepest_m <= deepest_m;
}

std::string WaterRange::text() const {
  std::ostringstream out;
  out << coldest_deg_c << " to " << warmest_deg_c << " deg C, " << freshest_psu << " to " << saltiest_psu
      << " psu, down to " << deepest_m << " m";
  return out.str();
}

WaterRange valid_range(SoundSpeedEquation equation) {
  switch (equation) {
    case SoundSpeedEquation::kUnesco:  // 1000 bar
      return {0, 40, 0, 40, 9700};
    case SoundSpeedEquation::kDelGrosso:  // 1000 kg/cm^2
      return {0, 30, 30, 40, 9500};
    case SoundSpeedEquation::kBelogolskii:  // 60 MPa
      return {0, 40, 0, 0, 6000};
    case SoundSpeedEquation::kLeroy:
      return {-1, 30, 0, 42, 12000};
    case SoundSpeedEquation::kMackenzie:
      return {2, 30, 25, 40, 8000};
    case SoundSpeedEquation::kMedwin:
      return {0, 35, 0, 45, 1000};
  }
  return {};
}

const std::vector<std::string>& sound_speed_equation_names() {
  static const std::vector<std::string> names = {"unesco", "del_grosso", "belogolskii", "leroy", "mackenzie", "medwin"};
  return names;
}

SoundSpeedEquation sound_speed_equation(std::string_view name) {
  return static_cast<SoundSpeedEquation>(index_of("water.sound_speed_equation", name, sound_speed_equation_names()));
}

const std::string& name_of(SoundSpeedEquation equation) {
  return sound_speed_equation_names()[static_cast<std::size_t>(equation)];
}

SoundSpeedEquation best_sound_speed_equation(const WaterRange& water) {
  using enum SoundSpeedEquation;
  constexpr double kDeep_m = 1000;
  if (valid_range(kBelogolskii).covers(water)) return kBelogolskii;
  if (water.deepest_m > kDeep_m && valid_range(kDelGrosso).covers(water)) return kDelGrosso;
  if (valid_range(kUnesco).covers(water) || !valid_range(kLeroy).covers(water)) return kUnesco;
  return kLeroy;
}

double sound_speed_m_s(SoundSpeedEquation equation, double t, double s, double d, double gauge_pressure_pa) {
  require(t >= -2 && t <= 40, "temperature_deg_c", t, "deg C: must be in [-2, 40] deg C");
  require(s >= 0 && s <= 45, "salinity_psu", s, "psu: must be in [0, 45] psu");
  require(d >= 0 && d <= 12000, "depth_m", with_unit(d, "m"), "must be in [0, 12000] m");
  require(gauge_pressure_pa >= 0 && gauge_pressure_pa <= 2e8, "gauge_pressure_pa", gauge_pressure_pa,
          "Pa: must be in [0, 2e8] Pa");
  switch (equation) {
    case SoundSpeedEquation::kUnesco:
      return unesco(t, s, gauge_pressure_pa / 1e5);
    case SoundSpeedEquation::kDelGrosso:
      return del_grosso(t, s, gauge_pressure_pa / 98066.5);
    case SoundSpeedEquation::kBelogolskii:
      return belogolskii(t, gauge_pressure_pa / 1e6);
    case SoundSpeedEquation::kLeroy:
      return leroy(t, s, d);
    case SoundSpeedEquation::kMackenzie:
      return mackenzie(t, s, d);
    case SoundSpeedEquation::kMedwin:
      return medwin(t, s, d);
  }
  return 0;
}

double sound_speed_m_s(double t, double s, double d, std::string_view equation) {
  require(d >= 0 && d <= 12000, "depth_m", with_unit(d, "m"), "must be in [0, 12000] m");
  const double light_pa = sea_water_density_kg_m3(t, s) * kStandardGravity_m_s2 * d;
  const SoundSpeedEquation used =
      equation == kAutomaticSoundSpeed ? best_sound_speed_equation({t, t, s, s, d}) : sound_speed_equation(equation);
  return sound_speed_m_s(used, t, s, d, compressed_pressure_pa(light_pa, t, s));
}

}  // namespace uwsim
