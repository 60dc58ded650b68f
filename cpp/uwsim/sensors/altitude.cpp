#include <cmath>

#include "uwsim/sensors/mounted_sensor.h"

namespace uwsim {
namespace {

/// Vertical distance (like that of a stabilised altimeter) to the first surface below, seabed or not. Beyond the
/// maximum range, the reading is infinity; below the minimum range, it is the minimum. Both readings are invalid.
class Altitude final : public MountedSensor {
 public:
  explicit Altitude(const SensorSpec& spec)
      : MountedSensor(spec), range_min_m_(spec.number("range_min_m")), range_max_m_(spec.number("range_max_m")) {}

  void observe(const SensorInput& input, std::span<double> raw) const override {
    const Ray down{world_from_sensor(input).position_m, -Eigen::Vector3d::UnitZ()};
    raw[0] = input.around.scene.cast(down, range_max_m_).distance_m;
  }

  std::optional<RayCone> rays(const Pose& world_from_body) const override {
    return RayCone{world_from_sensor(world_from_body).position_m, -Eigen::Vector3d::UnitZ(), 1, range_max_m_};
  }

  bool report(std::span<const double> raw, std::span<double> reading) const override {
    reading[0] = std::max(raw[0], range_min_m_);
    return std::isfinite(raw[0]) && raw[0] >= range_min_m_;
  }

 private:
  double range_min_m_, range_max_m_;
};

constexpr Field kAltitudeFields[] = {{"altitude_m", 1, "m"}};
constexpr Channel kAltitudeChannels[] = {{"altitude", 1, "m"}};
constexpr Parameter kAltitudeParameters[] = {
    {"range_min_m", 1, 0, 0, 1000, "m", "smaller distances are invalid"},
    {"range_max_m", 1, 1000, 0.1, 1000, "m", "larger distances are infinite and invalid"}};

}  // namespace

extern const SensorKind kAltitude;
constinit const SensorKind kAltitude = {"altitude",
                                        "vertical distance to the surface below; infinity beyond its range",
                                        kAltitudeFields,
                                        kAltitudeChannels,
                                        0,
                                        kAltitudeParameters,
                                        make_sensor<Altitude>};

}  // namespace uwsim
