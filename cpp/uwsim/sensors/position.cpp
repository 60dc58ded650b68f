#include "uwsim/sensors/mounted_sensor.h"

namespace uwsim {
namespace {

/// The sensor's position in the world: an ideal positioning system plus the configured errors.
class Position final : public MountedSensor {
 public:
  explicit Position(const SensorSpec& spec) : MountedSensor(spec) {}

  void observe(const SensorInput& input, std::span<double> raw) const override {
    Eigen::Vector3d::Map(&raw[0]) = world_from_sensor(input).position_m;
  }
};

constexpr Field kPositionFields[] = {{"position_m", 3, "m"}};
constexpr Channel kPositionChannels[] = {{"position", 3, "m"}};

}  // namespace

extern const SensorKind kPosition;
constinit const SensorKind kPosition = {
    "position", "position in the world, world axes", kPositionFields, kPositionChannels, 0, {}, make_sensor<Position>};

}  // namespace uwsim
