#include "uwsim/sensors/kinds.h"
#include "uwsim/sensors/scalar_sensor.h"

namespace uwsim {
namespace {

/// Depth under the mean water surface, positive down [m].
class Depth final : public ScalarSensor {
 public:
  explicit Depth(const SensorSpec& spec) : ScalarSensor("depth_m"), body_from_sensor_(spec.body_from_sensor) {}

 private:
  double value(const SensorInput& input) const override {
    return Water::depth_m(world_from_sensor(input, body_from_sensor_).position_m.z());
  }
  Pose body_from_sensor_;
};

}  // namespace

std::unique_ptr<Sensor> make_depth(const SensorSpec& spec) { return std::make_unique<Depth>(spec); }

}  // namespace uwsim
