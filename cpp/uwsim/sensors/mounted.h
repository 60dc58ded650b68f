#pragma once

#include "uwsim/sensors/sensor.h"

namespace uwsim {

/// A sensor that sits somewhere on the body, and what is there.
class Mounted : public Sensor {
 protected:
  explicit Mounted(const SensorSpec& spec) : body_from_sensor_(spec.body_from_sensor) {}

  Pose world_from_sensor(const SensorInput& input) const {
    return input.moment.state.world_from_body * body_from_sensor_;
  }
  Eigen::Vector3d sensor_axes(const Eigen::Vector3d& body) const {
    return body_from_sensor_.orientation.conjugate() * body;
  }
  /// Over ground, body axes: v + omega x r.
  Eigen::Vector3d velocity_body_m_s(const SensorInput& input) const {
    const BodyState& state = input.moment.state;
    return state.linear_body_m_s() + state.angular_body_rad_s().cross(body_from_sensor_.position_m);
  }
  /// Inertial, body axes: rate of body-axes velocity, to which the turning of the axes and the arm are added.
  Eigen::Vector3d acceleration_body_m_s2(const SensorInput& input) const {
    const Eigen::Vector3d v = input.moment.state.linear_body_m_s(), w = input.moment.state.angular_body_rad_s();
    const Eigen::Vector3d rate = input.moment.acceleration_body.tail<3>(), arm = body_from_sensor_.position_m;
    return input.moment.acceleration_body.head<3>() + w.cross(v) + rate.cross(arm) + w.cross(w.cross(arm));
  }

  Pose body_from_sensor_;
};

}  // namespace uwsim
