#include "uwsim/vehicle/windage.h"

#include <algorithm>
#include <cmath>

#include "uwsim/core/check.h"

namespace uwsim {

Vector6d Windage::load(const Eigen::Vector3d& air_body_m_s, double dry) const {
  const double ahead = air_body_m_s.x(), left = air_body_m_s.y();
  const double pressure_s_m = 0.5 * kAir_kg_m3 * std::clamp(dry, 0.0, 1.0);
  const double speed = std::hypot(ahead, left);
  const double x = pressure_s_m * speed * surge * frontal_area_m2 * ahead,
               y = pressure_s_m * speed * sway * lateral_area_m2 * left,
               n = -2 * pressure_s_m * yaw * lateral_area_m2 * length_m * ahead * left;
  Vector6d wrench;
  wrench << x, y, 0, -height_m * y, height_m * x, n;
  return wrench;
}

void Windage::check() const {
  for (const auto& [name, value] : {std::pair{"frontal_area_m2", frontal_area_m2},
                                    {"lateral_area_m2", lateral_area_m2},
                                    {"length_m", length_m},
                                    {"surge", surge},
                                    {"sway", sway},
                                    {"yaw", yaw},
                                    {"speed_share", speed_share},
                                    {"dry_volume_m3", dry_volume_m3}}) {
    require(std::isfinite(value) && value >= 0, std::string("windage.") + name, value, "must be 0 or positive");
  }
  require(std::isfinite(height_m), "windage.height_m", height_m, "must be finite");
}

}  // namespace uwsim
