#pragma once

#include <Eigen/Core>

#include "uwsim/control/motion_estimate.h"

namespace uwsim {

/// Gains in full effort per unit of error.
struct AutopilotGains {
  double speed = 0;            ///< per m/s
  double speed_integral = 0;   ///< per m
  double heading = 0;          ///< per rad
  double heading_rate = 0;     ///< per rad/s
  double height = 0;           ///< per m
  double height_rate = 0;      ///< per m/s
  double height_integral = 0;  ///< per m s
  double level = 0;            ///< per unit of sine of the tilt
  double level_rate = 0;       ///< per rad/s
};

/// A commanded heading, horizontal velocity and height.
struct Course {
  double heading_rad = 0;
  Eigen::Vector2d velocity_world_m_s = Eigen::Vector2d::Zero();
  double z_world_m = 0;
};

/// Maintains a course and keeps the vehicle level, without a model of the vehicle: a PI or PD loop for each axis
/// (Fossen 2011, "Handbook of Marine Craft Hydrodynamics and Motion Control", ch. 12). Integrals are limited: surge and
/// sway to full effort, height to half of it.
class Autopilot {
 public:
  Autopilot(double period_s, const AutopilotGains& gains) : gains(gains), period_s_(period_s) {}

  /// Computes the efforts of one control period, surge to yaw, each in [-1, 1].
  Vector6d steer(const MotionEstimate& estimate, const Course& course);

  AutopilotGains gains;
  /// Integrals of surge, sway and height, in units of effort. They are the only state carried from one period to the
  /// next.
  Eigen::Vector3d integrals = Eigen::Vector3d::Zero();

 private:
  double period_s_;
};

}  // namespace uwsim
