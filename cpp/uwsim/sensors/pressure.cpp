#include "uwsim/sensors/kinds.h"
#include "uwsim/sensors/scalar_sensor.h"

namespace uwsim {
namespace {

/// Absolute pressure [Pa].
class Pressure final : public ScalarSensor {
 public:
  explicit Pressure(const SensorSpec& spec) : ScalarSensor("pressure_pa"), body_from_sensor_(spec.body_from_sensor) {}

 private:
  double value(const SensorInput& input) const override {
    return input.water.pressure_pa(world_from_sensor(input, body_from_sensor_).position_m.z());
  }
  Pose body_from_sensor_;
};

}  // namespace

std::unique_ptr<Sensor> make_pressure(const SensorSpec& spec) { return std::make_unique<Pressure>(spec); }

}  // namespace uwsim
