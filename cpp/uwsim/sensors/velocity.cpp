#include "uwsim/sensors/mounted_sensor.h"

namespace uwsim {
namespace {

/// The sensor's velocity over ground and its angular velocity, in sensor axes: ideal odometry plus the configured
/// errors.
class Velocity final : public MountedSensor {
 public:
  explicit Velocity(const SensorSpec& spec) : MountedSensor(spec) {}

  void observe(const SensorInput& input, std::span<double> raw) const override {
    Eigen::Vector3d::Map(&raw[0]) = sensor_axes(velocity_body_m_s(input));
    Eigen::Vector3d::Map(&raw[3]) = sensor_axes(input.vehicle.state.angular_body_rad_s());
  }
};

constexpr Field kVelocityFields[] = {{"linear_velocity_m_s", 3, "m/s"}, {"angular_velocity_rad_s", 3, "rad/s"}};
constexpr Channel kVelocityChannels[] = {{"linear_velocity", 3, "m/s"}, {"angular_velocity", 3, "rad/s"}};

}  // namespace

extern const SensorKind kVelocity;
constinit const SensorKind kVelocity = {"velocity",
                                        "velocity over ground and angular velocity, sensor axes",
                                        kVelocityFields,
                                        kVelocityChannels,
                                        0,
                                        {},
                                        make_sensor<Velocity>};

}  // namespace uwsim
