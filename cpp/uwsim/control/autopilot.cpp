#include "uwsim/control/autopilot.h"

#include <cmath>

namespace uwsim {
namespace {

/// NaN passes through, so that the receiver of the effort can refuse it.
double clip(double value, double most) { return value < -most ? -most : value > most ? most : value; }

}  // namespace

Vector6d Autopilot::steer(const MotionEstimate& estimate, const Course& course) {
  const auto& nu = estimate.velocity_body;
  const Eigen::Vector3d up = estimate.world_from_body.row(2);  // the world's z axis in body axes
  const double yaw_rad = estimate.yaw_rad(), cos = std::cos(yaw_rad), sin = std::sin(yaw_rad);
  const double east_m_s = course.velocity_world_m_s.x(), north_m_s = course.velocity_world_m_s.y();
  Vector6d effort;

  const double surge_error = cos * east_m_s + sin * north_m_s - nu[0];
  const double sway_error = cos * north_m_s - sin * east_m_s - nu[1];
  effort[0] = gains.speed * surge_error + integrals[0];
  effort[1] = gains.speed * sway_error + integrals[1];
  const double share = gains.speed_integral * period_s_;
  integrals[0] = clip(integrals[0] + share * surge_error, 1.0);
  integrals[1] = clip(integrals[1] + share * sway_error, 1.0);

  effort[5] = gains.heading * wrap_angle(course.heading_rad - yaw_rad) - gains.heading_rate * nu[5];

  const double height_error = course.z_world_m - estimate.position_world_m.z();
  const double climb_m_s = up.x() * nu[0] + up.y() * nu[1] + up.z() * nu[2];
  effort[2] = gains.height * height_error - gains.height_rate * climb_m_s + integrals[2];
  const double step = gains.height_integral * period_s_ * clip(height_error, 1.0);
  integrals[2] = clip(integrals[2] + step, 0.5);

  // The Munk moment would pitch a slender vehicle over, so this turns the body's z axis back towards the world's.
  effort[3] = -gains.level * up.y() - gains.level_rate * nu[3];
  effort[4] = gains.level * up.x() - gains.level_rate * nu[4];

  for (double& each : effort) each = clip(each, 1.0);
  return effort;
}

}  // namespace uwsim
