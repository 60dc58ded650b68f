#include <cmath>
#include <limits>
#include <optional>

#include "uwsim/acoustics/modem/eigenrays.h"
#include "uwsim/sensors/mounted_sensor.h"

namespace uwsim {
namespace {

/// Acoustic position fix by an ultra-short baseline system at the station. The vehicle pings at the time of the sample;
/// the station measures travel time and direction and sends the fix back, which arrives after twice the travel time
/// along the ray that the sound-speed profile bends (direct_ray). The station is assumed to know the profile and to
/// correct range and direction for the bending, as long-range systems do when they have one (Kongsberg HiPAP, Sonardyne
/// Ranger 2; from memory): without errors, a fix is the true position. The range error acts along the line of sight.
/// The bearing error is two small angles across it, which cause an error of R x angle in position. There is no fix
/// (range 0, invalid) out of range, or in a shadow zone, which no direct ray reaches. Obstacles do not block the ray.
/// If `shares_modem` is set and the link uses modems, ping and fix are sent as packets over the link instead
/// (sim/position_exchange.h).
class Usbl final : public MountedSensor {
 public:
  explicit Usbl(const SensorSpec& spec)
      : MountedSensor(spec),
        range_max_m_(spec.number("range_max_m")),
        shares_modem_(flag(spec.parameters, "shares_modem")) {}

  void observe(const SensorInput& input, std::span<double> raw) const override {
    const Eigen::Vector3d line = from_station(input);
    raw[0] = line.norm();
    raw[1] = raw[2] = 0;
    Eigen::Vector3d::Map(&raw[3]) = raw[0] > 0 ? (line / raw[0]).eval() : -Eigen::Vector3d::UnitZ().eval();
    raw[6] = raw[0] <= range_max_m_ && ray_from_station(input);
  }

  bool report(std::span<const double> raw, std::span<double> reading) const override {
    const bool in_range = raw[6] > 0;
    const Eigen::Vector3d sight = Eigen::Vector3d::Map(&raw[3]);
    const Eigen::Vector3d across =
        (std::hypot(sight.x(), sight.y()) > 1e-9 ? Eigen::Vector3d(-sight.y(), sight.x(), 0).normalized()
                                                 : Eigen::Vector3d::UnitY().eval());
    const Eigen::Vector3d measured =
        (sight + std::tan(raw[1]) * across + std::tan(raw[2]) * sight.cross(across)).normalized();
    Eigen::Vector3d::Map(&reading[0]) = in_range ? (raw[0] * measured).eval() : Eigen::Vector3d::Zero().eval();
    reading[3] = in_range ? raw[0] : 0;
    reading[4] = in_range ? std::atan2(measured.y(), measured.x()) : 0;
    reading[5] = in_range ? std::asin(std::clamp(measured.z(), -1.0, 1.0)) : 0;
    return in_range;
  }

  double travel_time_s(const SensorInput& input) const override {
    const Eigen::Vector3d line = from_station(input);
    const auto ray = line.norm() <= range_max_m_ ? ray_from_station(input) : std::nullopt;
    if (ray) return 2 * ray->time_s;
    // After this time, no reply can arrive.
    return 2 * std::min(line.norm(), range_max_m_) / input.around.sound.at(depth_m(input.around.station_world_m));
  }

  double longest_travel_time_s() const override { return 2 * range_max_m_ / kSlowestSound_m_s; }
  bool shares_modem() const override { return shares_modem_; }

 private:
  static constexpr double kSlowestSound_m_s = 1000;  // no water is slower (fresh water at 0 deg C: 1402 m/s)

  Eigen::Vector3d from_station(const SensorInput& input) const {
    return world_from_sensor(input).position_m - input.around.station_world_m;
  }
  static double depth_m(const Eigen::Vector3d& point_world_m) { return std::max(0.0, -point_world_m.z()); }
  /// An end above the water is treated as if it were at the surface.
  std::optional<Eigenray> ray_from_station(const SensorInput& input) const {
    const Eigen::Vector3d line = from_station(input);
    return direct_ray(input.around.sound,
                      {depth_m(input.around.station_world_m), depth_m(input.around.station_world_m + line),
                       std::hypot(line.x(), line.y()), std::numeric_limits<double>::infinity()});
  }

  double range_max_m_;
  bool shares_modem_;
};

constexpr Field kUsblFields[] = {
    {"position_m", 3, "m"}, {"range_m", 1, "m"}, {"azimuth_rad", 1, "rad"}, {"elevation_rad", 1, "rad"}};
constexpr Channel kUsblChannels[] = {{"range", 1, "m"}, {"bearing", 2, "rad"}};
constexpr Parameter kUsblParameters[] = {
    {"range_max_m", 1, 1000, 1, 10000, "m", "from the station; no fix beyond"},
    {"shares_modem", 1, 1, 0, 1, "", "whether pings and fixes are packets of the link, where that has modems",
     ParameterType::kFlag}};

}  // namespace

extern const SensorKind kUsbl;
constinit const SensorKind kUsbl = {
    "usbl",
    "position from the station (world axes), range, azimuth from east to north, elevation (up is positive)",
    kUsblFields,
    kUsblChannels,
    4,
    kUsblParameters,
    make_sensor<Usbl>};

}  // namespace uwsim
