#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

#include "uwsim/sensors/mounted_sensor.h"

namespace uwsim {
namespace {

constexpr double kEarthRadius_m = 6371008.8;  // mean radius (Moritz 2000, GRS 80)
constexpr double kDegree = std::numbers::pi / 180;
constexpr double kStandardGravity_m_s2 = 9.80665;
constexpr std::uint64_t kOnce = std::numeric_limits<std::uint64_t>::max();  // keys the draws of a run

/// An unaided inertial navigation system whose height comes from a depth sensor. Its errors follow the equations of
/// Titterton and Weston 2004, "Strapdown inertial navigation technology", 2nd ed., ch. 12, in world axes, for the small
/// rotation phi of the computed attitude, the velocity error dv and the position error dp:
///
///   dv' = phi x f + C b_a + w_a,   phi' = C b_g + w_g + (dv_y, -dv_x, 0) / R,   dp' = dv
///
/// f: specific force; C: the sensor's attitude; b_a, b_g: biases, constant in a run; w_a, w_g: white noise; R: radius
/// of the Earth. At rest, dv and phi oscillate with Schuler's period 2 pi sqrt(R / g) = 84.4 min. The Earth's rotation
/// is left out: its coupling of the axes, with a period of 24 h, is small within the first hours. Where phi exceeds
/// kLargest_rad, sin(phi) differs from phi by 0.5 %: the equations no longer hold, and all later readings are invalid.
class Ins final : public MountedSensor {
 public:
  explicit Ins(const SensorSpec& spec)
      : MountedSensor(spec),
        gyro_bias_rad_s_(spec.number("gyro_bias_deg_h") * kDegree / 3600),
        gyro_walk_rad_s05_(spec.number("gyro_random_walk_deg_sqrt_h") * kDegree / 60),
        bias_m_s2_(spec.number("accelerometer_bias_ug") * 1e-6 * kStandardGravity_m_s2),
        walk_m_s15_(spec.number("accelerometer_noise_ug_sqrt_hz") * 1e-6 * kStandardGravity_m_s2),
        tilt_rad_(spec.number("tilt_std_deg") * kDegree),
        heading_rad_(spec.number("heading_std_deg") * kDegree),
        position_m_(spec.number("position_std_m")),
        velocity_m_s_(spec.number("velocity_std_m_s")) {}

  void observe(const SensorInput& input, std::span<double> raw) const override {
    const Pose sensor = world_from_sensor(input);
    raw[kHeight] = sensor.position_m.z();
    Eigen::Vector2d::Map(&raw[kPlace]) = sensor.position_m.head<2>();
    Eigen::Vector3d::Map(&raw[kVelocity]) = input.vehicle.state.world_from_body.direction(velocity_body_m_s(input));
    Eigen::Vector4d::Map(&raw[kAttitude]) = sensor.orientation.coeffs();
    for (std::size_t k = kErrors; k < kEnd; ++k) raw[k] = 0;
  }

  bool remembers() const override { return true; }
  void follow(const SensorInput& input, const Past& past, std::span<double> raw) const override {
    Eigen::Map<Eigen::Vector2d> dp(&raw[kErrors]), dv(&raw[kErrors + 2]);
    Eigen::Map<Eigen::Vector3d> phi(&raw[kErrors + 4]);
    if (past.raw.empty()) {
      dp = position_m_ * constants(past, 6).head<2>();
      dv = velocity_m_s_ * constants(past, 9).head<2>();
      phi = Eigen::Vector3d(tilt_rad_, tilt_rad_, heading_rad_).cwiseProduct(constants(past, 12));
      return;
    }
    for (std::size_t k = kErrors; k < kEnd; ++k) raw[k] = past.raw[k];
    if (phi.norm() > kLargest_rad) return;
    const double dt = past.elapsed_s, root = std::sqrt(dt);
    const auto draw = [&](std::uint32_t index) { return past.draws.normal(past.sample, index); };
    const Eigen::Matrix3d attitude = world_from_sensor(input).orientation.toRotationMatrix();
    const Eigen::Vector3d gyro = attitude * (gyro_bias_rad_s_ * constants(past, 0)) * dt +
                                 gyro_walk_rad_s05_ * root * Eigen::Vector3d(draw(0), draw(1), draw(2));
    const Eigen::Vector3d kick =
        attitude * (bias_m_s2_ * constants(past, 3)) * dt + walk_m_s15_ * root * Eigen::Vector3d(draw(3), draw(4), 0);
    Eigen::Vector3d force_s = Eigen::Vector3d::Map(&raw[kVelocity]) - Eigen::Vector3d::Map(&past.raw[kVelocity]);
    force_s.z() += input.around.water.gravity() * dt;  // the integral of the specific force
    const auto turn = [&] {
      return Eigen::Vector3d(0.5 * gyro + 0.5 * dt / kEarthRadius_m * Eigen::Vector3d(dv.y(), -dv.x(), 0));
    };
    const Eigen::Vector2d before = dv;  // leapfrog: half of the rotation before, half after the velocity
    phi += turn();
    dv += (phi.cross(force_s) + kick).head<2>();
    phi += turn();
    dp += 0.5 * dt * (before + dv);
  }

  bool report(std::span<const double> raw, std::span<double> reading) const override {
    const Eigen::Map<const Eigen::Vector3d> phi(&raw[kErrors + 4]);
    const double angle = phi.norm();
    const Eigen::Quaterniond error(
        Eigen::AngleAxisd(angle, angle > 0 ? Eigen::Vector3d(phi / angle) : Eigen::Vector3d::UnitX()));
    const Eigen::Quaterniond attitude{Eigen::Vector4d::Map(&raw[kAttitude])};
    for (std::size_t k = 0; k < 2; ++k) reading[k] = raw[kPlace + k] + raw[kErrors + k];
    reading[2] = raw[kHeight];
    for (std::size_t k = 0; k < 2; ++k) reading[3 + k] = raw[kVelocity + k] + raw[kErrors + 2 + k];
    reading[5] = raw[kVelocity + 2];
    Eigen::Vector4d::Map(&reading[6]) = (error * attitude).normalized().coeffs();
    return angle <= kLargest_rad;
  }

 private:
  static constexpr double kLargest_rad = 10 * kDegree;
  static constexpr std::size_t kHeight = 0, kPlace = 1, kVelocity = 3, kAttitude = 6, kErrors = 10, kEnd = 17;

  /// Three draws that are the same in the whole run.
  static Eigen::Vector3d constants(const Past& past, std::uint32_t first) {
    return {past.draws.normal(kOnce, first), past.draws.normal(kOnce, first + 1), past.draws.normal(kOnce, first + 2)};
  }

  double gyro_bias_rad_s_, gyro_walk_rad_s05_, bias_m_s2_, walk_m_s15_;
  double tilt_rad_, heading_rad_, position_m_, velocity_m_s_;
};

constexpr Field kInsFields[] = {{"position_m", 3, "m"}, {"velocity_m_s", 3, "m/s"}, {"orientation_xyzw", 4, "1"}};
constexpr Channel kInsChannels[] = {{"height", 1, "m"}};
constexpr Parameter kInsParameters[] = {
    {"gyro_bias_deg_h", 1, 0, 0, 1e5, "deg/h", "standard deviation of each axis's bias, drawn once per run"},
    {"gyro_random_walk_deg_sqrt_h", 1, 0, 0, 1e3, "deg/sqrt(h)", "angular random walk of the gyroscopes"},
    {"accelerometer_bias_ug", 1, 0, 0, 1e6, "ug", "standard deviation of each axis's bias, drawn once per run"},
    {"accelerometer_noise_ug_sqrt_hz", 1, 0, 0, 1e6, "ug/sqrt(Hz)", "white noise of the accelerometers"},
    {"tilt_std_deg", 1, 0, 0, 5, "deg", "error of roll and pitch, each, after the alignment"},
    {"heading_std_deg", 1, 0, 0, 10, "deg", "error of the heading after the alignment"},
    {"position_std_m", 1, 0, 0, 1e4, "m", "error of x and y, each, at the beginning"},
    {"velocity_std_m_s", 1, 0, 0, 10, "m/s", "error of the velocity along x and y, each, at the beginning"}};

}  // namespace

extern const SensorKind kIns;
constinit const SensorKind kIns = {
    "ins",
    "position, velocity (world axes) and attitude of an unaided inertial navigation system with a depth sensor",
    kInsFields,
    kInsChannels,
    16,
    kInsParameters,
    make_sensor<Ins>};

}  // namespace uwsim
