#include "uwsim/world/wind.h"

#include <cmath>

#include "uwsim/core/check.h"

namespace uwsim {

Eigen::Vector3d Wind::velocity_m_s(double time_s) const {
  double speed = speed_m_s;
  for (const Gust& gust : gusts) speed += gust.amplitude_m_s * std::cos(gust.omega_rad_s * time_s + gust.phase_rad);
  return speed * direction;
}

void Wind::check() const {
  require(speed_m_s >= 0 && speed_m_s <= 100, "wind.speed_m_s", speed_m_s, "must be in [0, 100] m/s");
  require(std::abs(direction.norm() - 1) < 1e-9 && direction.z() == 0, "wind.direction", direction.transpose(),
          "must be a level unit vector");
  for (const Gust& gust : gusts) {
    require(std::isfinite(gust.amplitude_m_s + gust.omega_rad_s + gust.phase_rad), "wind.gusts", gust.omega_rad_s,
            "must be finite");
  }
}

}  // namespace uwsim
