#include "uwsim/sensors/mounted_sensor.h"

namespace uwsim {
namespace {

/// Angular velocity and specific force (as accelerometers measure it: f = a - g) in sensor axes, and the sensor's
/// orientation in the world, as in sensor_msgs/Imu. Groves 2013, "Principles of GNSS, Inertial...", ch. 4. The
/// orientation error is a small rotation about the sensor's axes.
class Imu final : public MountedSensor {
 public:
  explicit Imu(const SensorSpec& spec) : MountedSensor(spec) {}

  void observe(const SensorInput& input, std::span<double> raw) const override {
    const Eigen::Quaterniond& attitude = input.vehicle.state.world_from_body.orientation;
    const Eigen::Vector3d gravity(0, 0, -input.around.water.gravity());
    Eigen::Map<Eigen::Matrix<double, 13, 1>> out(raw.data());
    out.segment<3>(0) = sensor_axes(input.vehicle.state.angular_body_rad_s());
    out.segment<3>(3) = sensor_axes(acceleration_body_m_s2(input) - attitude.conjugate() * gravity);
    out.segment<3>(6).setZero();
    out.segment<4>(9) = (attitude * body_from_sensor_.orientation).normalized().coeffs();
  }

  bool report(std::span<const double> raw, std::span<double> reading) const override {
    std::copy(raw.begin(), raw.begin() + 6, reading.begin());
    const Eigen::Vector3d error = Eigen::Vector3d::Map(&raw[6]);
    Eigen::Quaterniond orientation(Eigen::Vector4d::Map(&raw[9]));
    if (const double angle = error.norm(); angle > 0) {
      orientation = (orientation * Eigen::Quaterniond(Eigen::AngleAxisd(angle, error / angle))).normalized();
    }
    Eigen::Vector4d::Map(&reading[6]) = orientation.coeffs();
    return true;
  }
};

constexpr Field kFields[] = {
    {"angular_velocity_rad_s", 3, "rad/s"}, {"linear_acceleration_m_s2", 3, "m/s2"}, {"orientation_xyzw", 4, "1"}};
constexpr Channel kChannels[] = {
    {"angular_velocity", 3, "rad/s"}, {"linear_acceleration", 3, "m/s2"}, {"orientation", 3, "rad"}};

}  // namespace

extern const SensorKind kImu;
constinit const SensorKind kImu = {"imu",
                                   "angular velocity, specific force (sensor axes) and orientation (world from sensor)",
                                   kFields,
                                   kChannels,
                                   4,
                                   {},
                                   make_sensor<Imu>};

}  // namespace uwsim
