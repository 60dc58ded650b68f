#include "uwsim/sensors/mounted_sensor.h"

namespace uwsim {
namespace {

/// Measures the distance along the sensor's x axis to the nearest surface. As in the paper, the reading is the maximum
/// range if there is none.
class Proximity final : public MountedSensor {
 public:
  explicit Proximity(const SensorSpec& spec)
      : MountedSensor(spec), range_min_m_(spec.number("range_min_m")), range_max_m_(spec.number("range_max_m")) {}

  void observe(const SensorInput& input, std::span<double> raw) const override {
    const Pose sensor = world_from_sensor(input);
    const Ray ahead{sensor.position_m, sensor.direction(Eigen::Vector3d::UnitX())};
    const double distance_m = input.around.scene.cast(ahead, range_max_m_).distance_m;
    // Sound does not leave the water.
    const bool under_water =
        ahead.origin_world_m.z() <= 0 && (ahead.origin_world_m + distance_m * ahead.direction_world).z() <= 0;
    raw[0] = under_water ? distance_m : range_max_m_;
  }

  std::optional<RayCone> rays(const Pose& world_from_body) const override {
    const Pose sensor = world_from_sensor(world_from_body);
    return RayCone{sensor.position_m, sensor.direction(Eigen::Vector3d::UnitX()), 1, range_max_m_};
  }

  bool report(std::span<const double> raw, std::span<double> reading) const override {
    reading[0] = std::clamp(raw[0], range_min_m_, range_max_m_);
    return true;
  }

 private:
  double range_min_m_, range_max_m_;
};

constexpr Field kProximityFields[] = {{"range_m", 1, "m"}};
constexpr Channel kProximityChannels[] = {{"range", 1, "m"}};
constexpr Parameter kProximityParameters[] = {
    {"range_min_m", 1, 0, 0, 1000, "m", "smaller distances read as this"},
    {"range_max_m", 1, kRequired, 0.1, 1000, "m", "larger distances read as this"}};

}  // namespace

extern const SensorKind kProximity;
constinit const SensorKind kProximity = {
    "proximity",
    "distance along the sensor's x to the nearest surface; the maximum range without one",
    kProximityFields,
    kProximityChannels,
    0,
    kProximityParameters,
    make_sensor<Proximity>};

}  // namespace uwsim
