#include <cmath>

#include "uwsim/sensors/mounted_sensor.h"

namespace uwsim {
namespace {

constexpr double kStandard_ms_cm = 42.914;   // C(35, 15, 0): Culkin and Smith 1980, IEEE J. Oceanic Eng. 5:22
constexpr double kIpts68PerIts90 = 1.00024;  // Saunders 1990

/// The Practical Salinity Scale 1978 (Fofonoff and Millard 1983, UNESCO Technical Papers in Marine Science 44):
/// conductivity ratios at temperature t [deg C, IPTS-68] and gauge pressure p [dbar]. Valid for 2 to 42 psu, -2 to
/// 35 deg C and 0 to 10000 dbar; below 2 psu it is extrapolated, with an error of up to 0.01 psu.
double ratio_of_temperature(double t) {
  return 0.6766097 + t * (2.00564e-2 + t * (1.104259e-4 + t * (-6.9698e-7 + t * 1.0031e-9)));
}
double salinity_of_root(double root, double t) {
  const double share = (t - 15) / (1 + 0.0162 * (t - 15));
  const double at_15 =
      0.0080 + root * (-0.1692 + root * (25.3851 + root * (14.0941 + root * (-7.0261 + root * 2.7081))));
  const double beside =
      0.0005 + root * (-0.0056 + root * (-0.0066 + root * (-0.0375 + root * (0.0636 - root * 0.0144))));
  return at_15 + share * beside;
}
double slope_of_root(double root, double t) {
  const double share = (t - 15) / (1 + 0.0162 * (t - 15));
  return -0.1692 + root * (50.7702 + root * (42.2823 + root * (-28.1044 + root * 13.5405))) +
         share * (-0.0056 + root * (-0.0132 + root * (-0.1125 + root * (0.2544 - root * 0.072))));
}
/// R_p = 1 + upper / (1 + d1 t + d2 t^2 + (d3 + d4 t) R)
double pressure_part(double p) { return p * (2.070e-5 + p * (-6.370e-10 + p * 3.989e-15)); }

double salinity_psu(double conductivity_ms_cm, double temperature_deg_c, double p) {
  const double t = kIpts68PerIts90 * temperature_deg_c, ratio = conductivity_ms_cm / kStandard_ms_cm;
  if (!(ratio > 0)) return 0;
  const double of_pressure =
      1 + pressure_part(p) / (1 + 3.426e-2 * t + 4.464e-4 * t * t + (0.4215 - 3.107e-3 * t) * ratio);
  return std::max(0.0, salinity_of_root(std::sqrt(ratio / (of_pressure * ratio_of_temperature(t))), t));
}

/// Inverts the scale: Newton's method for the root of R_t, then the quadratic equation for R.
double conductivity_ms_cm(double salinity, double temperature_deg_c, double p) {
  if (!(salinity > 0)) return 0;
  const double t = kIpts68PerIts90 * temperature_deg_c;
  double root = std::sqrt(salinity / 35);
  for (int k = 0; k < 8; ++k)
    root = std::max(1e-6, root - (salinity_of_root(root, t) - salinity) / slope_of_root(root, t));
  const double even = root * root * ratio_of_temperature(t);  // R / R_p
  const double a = 0.4215 - 3.107e-3 * t, b = 1 + 3.426e-2 * t + 4.464e-4 * t * t;
  const double half = 0.5 * (b - a * even);
  const double upper = even * (b + pressure_part(p));
  return kStandard_ms_cm * (std::sqrt(half * half + a * upper) - half) / a;
}

/// Conductivity, temperature and pressure of the water at the sensor, and the practical salinity that follows from the
/// three, with their errors, as an instrument computes it. Out of the water: no conductivity, invalid. No thermal lag
/// of the cell.
class Ctd final : public MountedSensor {
 public:
  explicit Ctd(const SensorSpec& spec) : MountedSensor(spec) {}

  void observe(const SensorInput& input, std::span<double> raw) const override {
    const Eigen::Vector3d place = world_from_sensor(input).position_m;
    const Water& water = input.around.water;
    const bool wet = place.z() < water.surface_height_at(place.x(), place.y(), input.time_s);
    raw[1] = water.temperature_deg_c(place, input.time_s);
    raw[2] = 1e-4 * (water.pressure_pa(place, input.time_s) - water.atmospheric_pressure_pa);
    raw[0] = wet ? conductivity_ms_cm(water.salinity_at_psu(place, input.time_s), raw[1], raw[2]) : 0;
    raw[3] = wet;
  }

  bool report(std::span<const double> raw, std::span<double> reading) const override {
    std::copy_n(raw.begin(), 3, reading.begin());
    reading[3] = salinity_psu(raw[0], raw[1], raw[2]);
    return raw[3] > 0;
  }
};

constexpr Field kCtdFields[] = {{"conductivity_ms_cm", 1, "mS/cm"},
                                {"temperature_deg_c", 1, "deg C"},
                                {"pressure_dbar", 1, "dbar"},
                                {"salinity_psu", 1, "psu"}};
constexpr Channel kCtdChannels[] = {{"conductivity", 1, "mS/cm"}, {"temperature", 1, "deg C"}, {"pressure", 1, "dbar"}};

}  // namespace

extern const SensorKind kCtd;
constinit const SensorKind kCtd = {"ctd",
                                   "conductivity, temperature and gauge pressure of the water, and its salinity",
                                   kCtdFields,
                                   kCtdChannels,
                                   1,
                                   {},
                                   make_sensor<Ctd>};

}  // namespace uwsim
