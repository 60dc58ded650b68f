#include <cmath>
#include <numbers>

#include "uwsim/sensors/mounted_sensor.h"

namespace uwsim {
namespace {

/// Magnetic heading of the sensor's x axis, clockwise from magnetic north, in [0, 2 pi). The sum of the earth's field
/// (strength, inclination below the horizon, declination east of the world's north, +y) and the vehicle's own field in
/// sensor axes ("hard iron") is levelled with the true roll and pitch; the heading is the atan2 of the level
/// components. Hard iron h therefore rotates the heading by about h_across / (B cos I). Groves 2013, "Principles of
/// GNSS, Inertial...", ch. 6.1.
class Compass final : public MountedSensor {
 public:
  explicit Compass(const SensorSpec& spec) : MountedSensor(spec), hard_iron_ut_(spec.vector3("hard_iron_ut")) {
    constexpr double kDegree = std::numbers::pi / 180;
    const double declination = spec.number("declination_deg") * kDegree;
    const double inclination = spec.number("inclination_deg") * kDegree;
    field_world_ut_ = spec.number("field_ut") * Eigen::Vector3d(std::sin(declination) * std::cos(inclination),
                                                                std::cos(declination) * std::cos(inclination),
                                                                -std::sin(inclination));
  }

  void observe(const SensorInput& input, std::span<double> raw) const override {
    const Pose sensor = world_from_sensor(input);
    const Eigen::Vector3d ahead = sensor.direction(Eigen::Vector3d::UnitX());
    const Eigen::Vector3d measured_world_ut = field_world_ut_ + sensor.direction(hard_iron_ut_);
    // The horizontal angle from the sensor's x axis to the field, counter-clockwise.
    raw[0] = std::atan2(ahead.x() * measured_world_ut.y() - ahead.y() * measured_world_ut.x(),
                        ahead.x() * measured_world_ut.x() + ahead.y() * measured_world_ut.y());
  }

  bool report(std::span<const double> raw, std::span<double> reading) const override {
    reading[0] = turned_once_rad(raw[0]);
    return true;
  }

 private:
  Eigen::Vector3d hard_iron_ut_;
  Eigen::Vector3d field_world_ut_;
};

constexpr Field kCompassFields[] = {{"heading_rad", 1, "rad"}};
constexpr Channel kCompassChannels[] = {{"heading", 1, "rad"}};
constexpr Parameter kCompassParameters[] = {
    {"hard_iron_ut", 3, 0, -1000, 1000, "uT", "the vehicle's own field, sensor axes"},
    {"declination_deg", 1, 0, -180, 180, "deg", "magnetic north east of true north"},
    {"inclination_deg", 1, 60, -89, 89, "deg", "of the field below the horizon (assumed: middle latitudes)"},
    {"field_ut", 1, 50, 1, 100, "uT", "the earth's field (IGRF: 25 to 65 uT)"}};

}  // namespace

extern const SensorKind kCompass;
constinit const SensorKind kCompass = {"compass",
                                       "magnetic heading, clockwise from magnetic north",
                                       kCompassFields,
                                       kCompassChannels,
                                       0,
                                       kCompassParameters,
                                       make_sensor<Compass>};

}  // namespace uwsim
