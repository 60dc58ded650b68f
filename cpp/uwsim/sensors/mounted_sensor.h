#pragma once

#include <cmath>
#include <numbers>

#include "uwsim/sensors/sensor.h"

namespace uwsim {

/// An angle in [0, 2 pi).
inline double turned_once_rad(double angle) {
  constexpr double kTurn = 2 * std::numbers::pi;
  const double rest = std::fmod(angle, kTurn), turned = rest < 0 ? rest + kTurn : rest;
  return turned < kTurn ? turned : 0;
}

/// A sensor mounted at a fixed pose on the body, and the motion of that point.
class MountedSensor : public Sensor {
 protected:
  explicit MountedSensor(const SensorSpec& spec) : body_from_sensor_(spec.body_from_sensor) {}

  Pose world_from_sensor(const SensorInput& input) const {
    return world_from_sensor(input.vehicle.state.world_from_body);
  }
  Pose world_from_sensor(const Pose& world_from_body) const { return world_from_body * body_from_sensor_; }
  Eigen::Vector3d sensor_axes(const Eigen::Vector3d& body) const {
    return body_from_sensor_.orientation.conjugate() * body;
  }
  /// Velocity over ground, body axes: v + omega x r.
  Eigen::Vector3d velocity_body_m_s(const SensorInput& input) const {
    const BodyState& state = input.vehicle.state;
    return state.linear_body_m_s() + state.angular_body_rad_s().cross(body_from_sensor_.position_m);
  }
  /// Inertial acceleration, body axes: the rate of change of the velocity in body axes, plus terms for the rotation of
  /// the axes and for the lever arm.
  Eigen::Vector3d acceleration_body_m_s2(const SensorInput& input) const {
    const Eigen::Vector3d v = input.vehicle.state.linear_body_m_s(), w = input.vehicle.state.angular_body_rad_s();
    const Eigen::Vector3d rate = input.vehicle.acceleration_body.tail<3>(), arm = body_from_sensor_.position_m;
    return input.vehicle.acceleration_body.head<3>() + w.cross(v) + rate.cross(arm) + w.cross(w.cross(arm));
  }

  Pose body_from_sensor_;
};

}  // namespace uwsim
