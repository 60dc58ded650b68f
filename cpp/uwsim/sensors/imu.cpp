#include "uwsim/sensors/kinds.h"

namespace uwsim {
namespace {

/// Angular velocity and specific force (what accelerometers feel: f = a - g) in the sensor's frame, and the sensor's
/// orientation in the world, as in sensor_msgs/Imu. Groves 2013, "Principles of GNSS, Inertial...", ch. 4.
class Imu final : public Sensor {
 public:
  explicit Imu(const SensorSpec& spec) : body_from_sensor_(spec.body_from_sensor) {}

  std::span<const Field> fields() const override {
    static constexpr std::array<Field, 3> kFields = {
        {{"angular_velocity_rad_s", 3}, {"linear_acceleration_m_s2", 3}, {"orientation_xyzw", 4}}};
    return kFields;
  }

  std::size_t noisy_values() const override { return 6; }  // rates and forces; the orientation stays a unit quaternion

  void measure(const SensorInput& input, std::span<double> out) const override {
    const Eigen::Vector3d w = input.state.angular_body_rad_s();
    const Eigen::Vector3d rate = input.acceleration_body.tail<3>();
    const Eigen::Vector3d arm = body_from_sensor_.position_m;
    const Eigen::Quaterniond& attitude = input.state.world_from_body.orientation;
    const Eigen::Vector3d gravity(0, 0, -input.water.gravity_m_s2);
    // From the rate of body-frame velocity to inertial acceleration, then to the sensor's place.
    const Eigen::Vector3d at_origin = input.acceleration_body.head<3>() + w.cross(input.state.linear_body_m_s());
    const Eigen::Vector3d at_sensor = at_origin + rate.cross(arm) + w.cross(w.cross(arm));
    const Eigen::Quaterniond sensor_from_body = body_from_sensor_.orientation.conjugate();
    Eigen::Map<Eigen::VectorXd> reading(out.data(), 10);
    reading.segment<3>(0) = sensor_from_body * w;
    reading.segment<3>(3) = sensor_from_body * (at_sensor - attitude.conjugate() * gravity);
    reading.segment<4>(6) = (attitude * body_from_sensor_.orientation).coeffs();
  }

 private:
  Pose body_from_sensor_;
};

}  // namespace

std::unique_ptr<Sensor> make_imu(const SensorSpec& spec) { return std::make_unique<Imu>(spec); }

}  // namespace uwsim
