#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <numbers>

#include "uwsim/sensors/mounted_sensor.h"

namespace uwsim {
namespace {

constexpr int kBeams = 4;

/// Doppler velocity log with four beams in Janus configuration (Brokloff 1994, "Matrix algorithm for Doppler sonar
/// navigation"): beam k points down, at the angle `beam_slant_deg` to the sensor's -z axis and the azimuth
/// `beam_azimuth_deg` + 90 k about +z. Each beam that hits a surface within range measures its range and the velocity
/// along the beam, b_k . v; the reading is the least-squares v. With fewer than three such beams, there is no bottom
/// lock: velocity 0, invalid (as Water Linked's DVLs report it). A beam without a hit has infinite range and velocity
/// 0.
class Dvl final : public MountedSensor {
 public:
  explicit Dvl(const SensorSpec& spec)
      : MountedSensor(spec), range_min_m_(spec.number("range_min_m")), range_max_m_(spec.number("range_max_m")) {
    constexpr double kDegree = std::numbers::pi / 180;
    const double slant = spec.number("beam_slant_deg") * kDegree;
    for (int k = 0; k < kBeams; ++k) {
      const double azimuth = (spec.number("beam_azimuth_deg") + 90 * k) * kDegree;
      beams_.row(k) << std::sin(slant) * std::cos(azimuth), std::sin(slant) * std::sin(azimuth), -std::cos(slant);
    }
  }

  void observe(const SensorInput& input, std::span<double> raw) const override {
    const Pose sensor = world_from_sensor(input);
    const Eigen::Vector3d velocity = sensor_axes(velocity_body_m_s(input));
    std::array<Ray, kBeams> rays;
    std::array<RayHit, kBeams> hits;
    for (int k = 0; k < kBeams; ++k) {
      rays[static_cast<std::size_t>(k)] = {sensor.position_m, sensor.direction(beams_.row(k).transpose()).normalized()};
    }
    input.around.scene.cast(rays, range_max_m_, hits);
    Eigen::Vector4d::Map(&raw[0]) = beams_ * velocity;
    for (std::size_t k = 0; k < kBeams; ++k) raw[kBeams + k] = hits[k].distance_m;
  }

  std::optional<RayCone> rays(const Pose& world_from_body) const override {
    const Pose sensor = world_from_sensor(world_from_body);
    return RayCone{sensor.position_m, sensor.direction(-Eigen::Vector3d::UnitZ()), -beams_.col(2).maxCoeff(),
                   range_max_m_};
  }

  bool report(std::span<const double> raw, std::span<double> reading) const override {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    int locked = 0;
    for (int k = 0; k < kBeams; ++k) {
      const auto beam = static_cast<std::size_t>(k);
      const double range_m = raw[kBeams + beam];
      const bool returned = std::isfinite(range_m) && range_m >= range_min_m_;
      reading[3 + beam] = returned ? range_m : std::numeric_limits<double>::infinity();
      reading[3 + kBeams + beam] = returned ? raw[beam] : 0;
      if (!returned) continue;
      ++locked;
      normal += beams_.row(k).transpose() * beams_.row(k);
      right += raw[beam] * beams_.row(k).transpose();
    }
    const bool bottom_lock = locked >= 3;
    Eigen::Vector3d::Map(&reading[0]) =
        bottom_lock ? normal.ldlt().solve(right).eval() : Eigen::Vector3d::Zero().eval();
    reading[3 + 2 * kBeams] = bottom_lock;
    return bottom_lock;
  }

 private:
  double range_min_m_, range_max_m_;
  Eigen::Matrix<double, kBeams, 3> beams_;  ///< unit, sensor axes
};

constexpr Field kDvlFields[] = {{"velocity_m_s", 3, "m/s"},
                                {"beam_ranges_m", kBeams, "m"},
                                {"beam_velocities_m_s", kBeams, "m/s"},
                                {"bottom_lock", 1, "1"}};
constexpr Channel kDvlChannels[] = {{"beam_velocity", kBeams, "m/s"}, {"beam_range", kBeams, "m"}};
constexpr Parameter kDvlParameters[] = {
    {"beam_slant_deg", 1, 30, 5, 60, "deg", "from the sensor's -z"},
    {"beam_azimuth_deg", 1, 45, -360, 360, "deg", "of the first beam about the sensor's +z, from its x"},
    {"range_min_m", 1, 0, 0, 1000, "m", "along a beam; closer beams are lost"},
    {"range_max_m", 1, 100, 0.1, 1000, "m", "along a beam; farther beams are lost"}};

}  // namespace

extern const SensorKind kDvl;
constinit const SensorKind kDvl = {
    "dvl",
    "velocity over the bottom (sensor axes), range and velocity along each of four beams, bottom lock (1 or 0)",
    kDvlFields,
    kDvlChannels,
    0,
    kDvlParameters,
    make_sensor<Dvl>};

}  // namespace uwsim
