#include "uwsim/sensors/mounted_sensor.h"

namespace uwsim {
namespace {

/// Inertial acceleration of the sensor (without gravity, unlike that of an IMU) and its angular acceleration, in sensor
/// axes.
class Acceleration final : public MountedSensor {
 public:
  explicit Acceleration(const SensorSpec& spec) : MountedSensor(spec) {}

  void observe(const SensorInput& input, std::span<double> raw) const override {
    Eigen::Vector3d::Map(&raw[0]) = sensor_axes(acceleration_body_m_s2(input));
    Eigen::Vector3d::Map(&raw[3]) = sensor_axes(input.vehicle.acceleration_body.tail<3>());
  }
};

constexpr Field kAccelerationFields[] = {{"linear_acceleration_m_s2", 3, "m/s2"},
                                         {"angular_acceleration_rad_s2", 3, "rad/s2"}};
constexpr Channel kAccelerationChannels[] = {{"linear_acceleration", 3, "m/s2"}, {"angular_acceleration", 3, "rad/s2"}};

}  // namespace

extern const SensorKind kAcceleration;
constinit const SensorKind kAcceleration = {"acceleration",
                                            "acceleration without gravity and angular acceleration, sensor axes",
                                            kAccelerationFields,
                                            kAccelerationChannels,
                                            0,
                                            {},
                                            make_sensor<Acceleration>};

}  // namespace uwsim
