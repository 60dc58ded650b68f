#include "uwsim/camera/optics.h"

#include <cmath>
#include <numbers>

#include "uwsim/core/check.h"

namespace uwsim {

void Optics::check() const {
  water.check();
  require(particles_per_m3 >= 0 && particles_per_m3 <= 64, "optics.particles_per_m3", particles_per_m3,
          "must be in [0, 64] 1/m3");
  require(turbulence_k >= 0 && turbulence_k <= 20, "optics.turbulence_k", turbulence_k, "must be in [0, 20] K");
}

double turbulence_bend_rad(double turbulence_k) {
  constexpr double kIndexPerK = 1e-4, kPath_m = 5, kEddy_m = 0.05;
  const double paths = 2 * std::sqrt(std::numbers::pi) / 3 * kPath_m / kEddy_m;
  return std::sqrt(paths) * kIndexPerK * turbulence_k;
}

}  // namespace uwsim
