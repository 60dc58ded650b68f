#include "uwsim/sensors/kinds.h"
#include "uwsim/sensors/scalar_sensor.h"

namespace uwsim {
namespace {

/// Water temperature [deg C].
class Temperature final : public ScalarSensor {
 public:
  explicit Temperature(const SensorSpec& spec)
      : ScalarSensor("temperature_deg_c"), body_from_sensor_(spec.body_from_sensor) {}

 private:
  double value(const SensorInput& input) const override {
    return input.water.temperature_deg_c(world_from_sensor(input, body_from_sensor_).position_m.z());
  }
  Pose body_from_sensor_;
};

}  // namespace

std::unique_ptr<Sensor> make_temperature(const SensorSpec& spec) { return std::make_unique<Temperature>(spec); }

}  // namespace uwsim
