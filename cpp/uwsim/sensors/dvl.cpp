#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "uwsim/sensors/mounted_sensor.h"

namespace uwsim {
namespace {

constexpr int kBeams = 4;
using Beams = Eigen::Matrix<double, kBeams, 3>;

/// Unit vectors of four beams in Janus configuration, sensor axes: beam k points down, at the angle `beam_slant_deg` to
/// the sensor's -z axis and the azimuth `beam_azimuth_deg` + 90 k about +z.
Beams janus(const SensorSpec& spec) {
  constexpr double kDegree = std::numbers::pi / 180;
  const double slant = spec.number("beam_slant_deg") * kDegree;
  Beams beams;
  for (int k = 0; k < kBeams; ++k) {
    const double azimuth = (spec.number("beam_azimuth_deg") + 90 * k) * kDegree;
    beams.row(k) << std::sin(slant) * std::cos(azimuth), std::sin(slant) * std::sin(azimuth), -std::cos(slant);
  }
  return beams;
}

/// Sums of the least-squares velocity v of beams that measure b_k . v.
struct LeastSquares {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  int beams = 0;

  void add(const Eigen::Vector3d& beam, double along_m_s) {
    normal += beam * beam.transpose();
    right += along_m_s * beam;
    ++beams;
  }
  Eigen::Vector3d solution() const { return normal.ldlt().solve(right); }
};

/// Doppler velocity log with four beams in Janus configuration (Brokloff 1994, "Matrix algorithm for Doppler sonar
/// navigation"). Each beam that hits a surface within range measures its range and the velocity
/// along the beam, b_k . v; the reading is the least-squares v. With fewer than three such beams, there is no bottom
/// lock: velocity 0, invalid (as Water Linked's DVLs report it). A beam without a hit has infinite range and velocity
/// 0.
///
/// Doppler shifts become velocities by a speed of sound: one that is set, or that of the water at the instrument. The
/// channel `scale` is the relative error of all velocities beyond that, `misalignment` the small rotation of the beams
/// about the sensor's axes (Kinsey and Whitcomb 2007, "In situ alignment calibration of attitude and Doppler sensors
/// for precision underwater vehicle navigation", IEEE J. Oceanic Engineering 32:286).
class Dvl final : public MountedSensor {
 public:
  explicit Dvl(const SensorSpec& spec)
      : MountedSensor(spec),
        range_min_m_(spec.number("range_min_m")),
        range_max_m_(spec.number("range_max_m")),
        set_sound_m_s_(spec.number("sound_speed_m_s")),
        beams_(janus(spec)) {}

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
    for (std::size_t k = kScale; k < kEnd; ++k) raw[k] = 0;
    if (set_sound_m_s_ > 0) {
      raw[kScale] = set_sound_m_s_ / input.around.sound.at(std::max(-sensor.position_m.z(), 0.0)) - 1;
    }
  }

  std::optional<RayCone> rays(const Pose& world_from_body) const override {
    const Pose sensor = world_from_sensor(world_from_body);
    return RayCone{sensor.position_m, sensor.direction(-Eigen::Vector3d::UnitZ()), -beams_.col(2).maxCoeff(),
                   range_max_m_};
  }

  bool report(std::span<const double> raw, std::span<double> reading) const override {
    LeastSquares locked;
    const Eigen::Vector4d along_m_s = measured_m_s(raw);
    for (int k = 0; k < kBeams; ++k) {
      const auto beam = static_cast<std::size_t>(k);
      const double range_m = raw[kBeams + beam];
      const bool returned = std::isfinite(range_m) && range_m >= range_min_m_;
      reading[3 + beam] = returned ? range_m : std::numeric_limits<double>::infinity();
      reading[3 + kBeams + beam] = returned ? along_m_s[k] : 0;
      if (returned) locked.add(beams_.row(k), along_m_s[k]);
    }
    const bool bottom_lock = locked.beams >= 3;
    Eigen::Vector3d::Map(&reading[0]) = bottom_lock ? locked.solution() : Eigen::Vector3d::Zero().eval();
    reading[3 + 2 * kBeams] = bottom_lock;
    return bottom_lock;
  }

 private:
  static constexpr std::size_t kScale = 2 * kBeams, kMisalignment = kScale + 1, kEnd = kMisalignment + 3;

  /// The velocities along the beams with the errors of scale and alignment.
  Eigen::Vector4d measured_m_s(std::span<const double> raw) const {
    const Eigen::Vector4d along = Eigen::Vector4d::Map(&raw[0]);
    const Eigen::Vector3d turn = Eigen::Vector3d::Map(&raw[kMisalignment]);
    if (raw[kScale] == 0 && turn.isZero(0)) return along;
    LeastSquares all;
    for (int k = 0; k < kBeams; ++k) all.add(beams_.row(k), along[k]);
    return (1 + raw[kScale]) * (along + beams_ * all.solution().cross(turn));
  }

  double range_min_m_, range_max_m_, set_sound_m_s_;
  Beams beams_;
};

constexpr Field kDvlFields[] = {{"velocity_m_s", 3, "m/s"},
                                {"beam_ranges_m", kBeams, "m"},
                                {"beam_velocities_m_s", kBeams, "m/s"},
                                {"bottom_lock", 1, "1"}};
constexpr Channel kDvlChannels[] = {
    {"beam_velocity", kBeams, "m/s"}, {"beam_range", kBeams, "m"}, {"scale", 1, "1"}, {"misalignment", 3, "rad"}};
constexpr Parameter kDvlParameters[] = {
    {"beam_slant_deg", 1, 30, 5, 60, "deg", "from the sensor's -z"},
    {"beam_azimuth_deg", 1, 45, -360, 360, "deg", "of the first beam about the sensor's +z, from its x"},
    {"range_min_m", 1, 0, 0, 1000, "m", "along a beam; closer beams are lost"},
    {"range_max_m", 1, 100, 0.1, 1000, "m", "along a beam; farther beams are lost"},
    {"sound_speed_m_s", 1, 0, 0, 2000, "m/s", "that it is set to; 0: that of the water at the instrument"}};

constexpr int kCells = 32;  // of a reading; an instrument may have fewer

/// Acoustic Doppler current profiler with the beams of a DVL. Cell k is centred blanking_m + (k + 1/2) cell_size_m
/// below the sensor, along its -z axis. Each beam measures the velocity of the sensor relative to the water at the
/// centre of its part of the cell, b_k . (v - v_water), and a cell's velocity is the least-squares one of all four.
/// Where a beam meets the bed at the range r, only cells above r cos(slant) are good: below, the echo of the beam's
/// vertical side lobe from the bed is stronger (RD Instruments 1996, "Acoustic Doppler Current Profilers: Principles of
/// Operation", 2nd ed., ch. 9). The velocity through the water (water track) is the mean of the good cells whose
/// centres are within the reference layer.
class Adcp final : public MountedSensor {
 public:
  explicit Adcp(const SensorSpec& spec)
      : MountedSensor(spec),
        beams_(janus(spec)),
        cosine_(-beams_(0, 2)),
        blanking_m_(spec.number("blanking_m")),
        size_m_(spec.number("cell_size_m")),
        near_m_(spec.number("layer_near_m")),
        far_m_(spec.number("layer_far_m")),
        count_(whole_number(spec.parameters, "cell_count")) {}

  void observe(const SensorInput& input, std::span<double> raw) const override {
    const Pose sensor = world_from_sensor(input);
    const Eigen::Vector3d velocity = sensor.direction(sensor_axes(velocity_body_m_s(input)));
    std::array<Ray, kBeams> rays;
    std::array<RayHit, kBeams> hits;
    std::array<Eigen::Vector3d, kBeams> along;
    for (std::size_t k = 0; k < kBeams; ++k) {
      along[k] = sensor.direction(beams_.row(static_cast<Eigen::Index>(k)).transpose()).normalized();
      rays[k] = {sensor.position_m, along[k]};
    }
    input.around.scene.cast(rays, reach_m(), hits);
    const Water& water = input.around.water;
    for (std::size_t k = 0; k < kBeams; ++k) {
      for (int cell = 0; cell < kCells; ++cell) {
        const double down_m = blanking_m_ + (cell + 0.5) * size_m_;
        const Eigen::Vector3d point = sensor.position_m + down_m / cosine_ * along[k];
        const bool good = cell < count_ && down_m + 0.5 * size_m_ <= hits[k].distance_m * cosine_ &&
                          point.z() < water.surface_height_at(point.x(), point.y(), input.time_s);
        raw[kBeams * static_cast<std::size_t>(cell) + k] =
            good ? along[k].dot(velocity - water.flow_at(point, input.time_s).velocity_m_s)
                 : std::numeric_limits<double>::infinity();
      }
    }
  }

  std::optional<RayCone> rays(const Pose& world_from_body) const override {
    const Pose sensor = world_from_sensor(world_from_body);
    return RayCone{sensor.position_m, sensor.direction(-Eigen::Vector3d::UnitZ()), cosine_, reach_m()};
  }

  bool report(std::span<const double> raw, std::span<double> reading) const override {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    int layer = 0;
    for (int cell = 0; cell < kCells; ++cell) {
      const auto at = static_cast<std::size_t>(cell);
      LeastSquares fit;
      for (std::size_t k = 0; k < kBeams; ++k) {
        const double along = raw[kBeams * at + k];
        if (std::isfinite(along)) fit.add(beams_.row(static_cast<Eigen::Index>(k)).transpose(), along);
      }
      Eigen::Vector3d through = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
      if (fit.beams == kBeams) {
        through = fit.solution();
        const double down_m = blanking_m_ + (cell + 0.5) * size_m_;
        if (down_m >= near_m_ && down_m <= far_m_) {
          sum += through;
          ++layer;
        }
      }
      Eigen::Vector3d::Map(&reading[3 + 3 * at]) = through;
    }
    Eigen::Vector3d::Map(&reading[0]) = sum / std::max(layer, 1);
    reading[3 + 3 * kCells] = layer > 0;
    return layer > 0;
  }

 private:
  /// Beyond this range, a beam's echo from the bed spoils no cell.
  double reach_m() const { return (blanking_m_ + count_ * size_m_) / (cosine_ * cosine_); }

  Beams beams_;
  double cosine_, blanking_m_, size_m_, near_m_, far_m_;
  int count_;
};

constexpr Field kAdcpFields[] = {
    {"velocity_m_s", 3, "m/s"}, {"cell_velocities_m_s", 3 * kCells, "m/s"}, {"water_lock", 1, "1"}};
constexpr Channel kAdcpChannels[] = {{"cell_velocity", kBeams* kCells, "m/s"}};
constexpr Parameter kAdcpParameters[] = {
    {"beam_slant_deg", 1, 20, 5, 60, "deg", "from the sensor's -z"},
    {"beam_azimuth_deg", 1, 45, -360, 360, "deg", "of the first beam about the sensor's +z, from its x"},
    {"cell_count", 1, 20, 1, kCells, "1", "number of cells", ParameterType::kWholeNumber},
    {"cell_size_m", 1, 1, 0.01, 100, "m", "height of a cell"},
    {"blanking_m", 1, 0.5, 0, 100, "m", "from the sensor to the first cell"},
    {"layer_near_m", 1, 0, 0, 5000, "m", "below the sensor: begin of the layer of the water track"},
    {"layer_far_m", 1, 5000, 0, 5000, "m", "below the sensor: end of that layer"}};

}  // namespace

extern const SensorKind kAdcp;
constinit const SensorKind kAdcp = {
    "adcp",
    "velocity through the water (sensor axes): its mean (water track), that in each of 32 cells (x, y, z of the first "
    "cell, of the second ...; NaN where it is lost), and whether there is any (1 or 0)",
    kAdcpFields,
    kAdcpChannels,
    0,
    kAdcpParameters,
    make_sensor<Adcp>};

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
