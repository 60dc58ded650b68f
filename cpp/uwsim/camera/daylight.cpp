#include "uwsim/camera/daylight.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "uwsim/camera/refraction.h"
#include "uwsim/core/check.h"

namespace uwsim {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kSkyReflected = 0.066;

Bands optical_depth() {
  const Bands um(0.600, 0.550, 0.450);
  const Bands per_um2 = um.square().inverse();
  const Bands molecules = 0.008569 * per_um2.square() * (1 + 0.0113 * per_um2 + 0.00013 * per_um2.square());
  return molecules + 0.08 * (0.550 / um).pow(1.3);
}

double air_mass(double elevation_rad) {
  const double degrees = elevation_rad / kDegree;
  return 1 / (std::sin(elevation_rad) + 0.50572 * std::pow(degrees + 6.07995, -1.6364));
}

}  // namespace

Daylight daylight(const Sun& sun) {
  const double h = sun.elevation_rad;
  require(h >= -6.01 * kDegree && h <= 90.01 * kDegree, "optics.sun_elevation", h / kDegree, "must be in [-6, 90] deg");
  require(std::isfinite(sun.azimuth_rad), "optics.sun_azimuth", sun.azimuth_rad, "must be finite");
  Daylight light;
  light.to_sun_world = {std::cos(h) * std::cos(sun.azimuth_rad), std::cos(h) * std::sin(sun.azimuth_rad), std::sin(h)};
  const double up = std::max(h, 0.0);
  const Bands transmitted = (-optical_depth() * air_mass(up)).exp();
  light.beam = h > 0 ? transmitted : Bands::Zero().eval();
  const double twilight = 0.004 * std::clamp(std::sin(h + 6 * kDegree) / std::sin(6 * kDegree), 0.0, 1.0);
  light.sky = 0.5 * std::sin(up) * (1 - transmitted) + twilight * Bands(0.8, 0.9, 1.2);
  return light;
}

DaylightBelow daylight_below(const Daylight& above, double n) {
  DaylightBelow below;
  below.to_sun_world = Eigen::Vector3d::UnitZ();
  below.beam_level.setZero();
  below.sky_level = (1 - kSkyReflected) * above.sky;
  const double cosine = above.to_sun_world.z();
  if (cosine <= 0) return below;
  below.to_sun_world = -*refracted(-above.to_sun_world, Eigen::Vector3d::UnitZ(), 1, n);
  below.beam_level = (1 - fresnel_reflectance(cosine, 1, n)) * cosine * above.beam;
  return below;
}

}  // namespace uwsim
