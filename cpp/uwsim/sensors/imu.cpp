#include <string_view>
#include <vector>

#include "uwsim/sensors/mounted_sensor.h"

namespace uwsim {
namespace {

/// Angular velocity and specific force (as accelerometers measure it: f = a - g) in sensor axes, and the sensor's
/// orientation in the world, as in sensor_msgs/Imu. Groves 2013, "Principles of GNSS, Inertial...", ch. 4. The
/// orientation error is a small rotation about the sensor's axes.
///
/// Errors of scale and alignment, and the gyroscope's response to specific force (ibid., eq. 4.16 and 4.17):
///
///   f' = (I + M_a) f,   w' = (I + M_g) w + G_g f.
///
/// The diagonal of M contains the scale errors; its other elements are small angles, by which an axis also senses
/// another one. They do not vary with temperature or time, and the response is linear: no scale asymmetry, no vibration
/// rectification.
class Imu final : public MountedSensor {
 public:
  explicit Imu(const SensorSpec& spec)
      : MountedSensor(spec),
        of_rate_(scaled(spec, "gyro_scale", "gyro_misalignment_rad")),
        of_force_(scaled(spec, "accelerometer_scale", "accelerometer_misalignment_rad")),
        rate_of_force_(Matrix3d::Map(spec.parameters.find("gyro_g_sensitivity")->second.data())),
        is_exact_(of_rate_.isIdentity(0) && of_force_.isIdentity(0) && rate_of_force_.isZero(0)) {}

  void observe(const SensorInput& input, std::span<double> raw) const override {
    const Eigen::Quaterniond& attitude = input.vehicle.state.world_from_body.orientation;
    const Eigen::Vector3d gravity(0, 0, -input.around.water.gravity());
    Eigen::Map<Eigen::Matrix<double, 13, 1>> out(raw.data());
    out.segment<3>(0) = sensor_axes(input.vehicle.state.angular_body_rad_s());
    out.segment<3>(3) = sensor_axes(acceleration_body_m_s2(input) - attitude.conjugate() * gravity);
    out.segment<3>(6).setZero();
    out.segment<4>(9) = (attitude * body_from_sensor_.orientation).normalized().coeffs();
  }

  void distort(std::span<double> raw) const override {
    if (is_exact_) return;
    Eigen::Map<Eigen::Vector3d> rate(raw.data()), force(raw.data() + 3);
    rate = (of_rate_ * rate + rate_of_force_ * force).eval();
    force = (of_force_ * force).eval();
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

 private:
  using Matrix3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

  /// I + M.
  static Matrix3d scaled(const SensorSpec& spec, std::string_view scale, std::string_view angles) {
    const std::vector<double>& a = spec.parameters.find(angles)->second;
    Matrix3d matrix;
    matrix << 0, a[0], a[1], a[2], 0, a[3], a[4], a[5], 0;
    matrix.diagonal() = Eigen::Vector3d::Ones() + spec.vector3(scale);
    return matrix;
  }

  Matrix3d of_rate_, of_force_;
  Matrix3d rate_of_force_;  // rad/s for 1 m/s2
  bool is_exact_;
};

constexpr Field kImuFields[] = {
    {"angular_velocity_rad_s", 3, "rad/s"}, {"linear_acceleration_m_s2", 3, "m/s2"}, {"orientation_xyzw", 4, "1"}};
constexpr Channel kImuChannels[] = {
    {"angular_velocity", 3, "rad/s"}, {"linear_acceleration", 3, "m/s2"}, {"orientation", 3, "rad"}};
constexpr Parameter kImuParameters[] = {
    {"gyro_scale", 3, 0, -0.5, 0.5, "1", "relative error of the gyroscope's scale, by axis"},
    {"gyro_misalignment_rad", 6, 0, -0.2, 0.2, "rad", "what x senses of y and z, y of x and z, z of x and y"},
    {"gyro_g_sensitivity", 9, 0, -0.1, 0.1, "rad s/m",
     "the gyroscope's response to specific force: xx, xy, xz, yx ..."},
    {"accelerometer_scale", 3, 0, -0.5, 0.5, "1", "relative error of the accelerometer's scale, by axis"},
    {"accelerometer_misalignment_rad", 6, 0, -0.2, 0.2, "rad", "as the gyroscope's"}};

}  // namespace

extern const SensorKind kImu;
constinit const SensorKind kImu = {"imu",
                                   "angular velocity, specific force (sensor axes) and orientation (world from sensor)",
                                   kImuFields,
                                   kImuChannels,
                                   4,
                                   kImuParameters,
                                   make_sensor<Imu>};

}  // namespace uwsim
