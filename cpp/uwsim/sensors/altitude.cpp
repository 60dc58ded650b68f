#include <limits>

#include "uwsim/sensors/kinds.h"
#include "uwsim/sensors/scalar_sensor.h"

namespace uwsim {
namespace {

/// Distance straight down to whatever lies below, seabed or not [m]; infinity past the range.
class Altitude final : public ScalarSensor {
 public:
  explicit Altitude(const SensorSpec& spec)
      : ScalarSensor("altitude_m"),
        body_from_sensor_(spec.body_from_sensor),
        range_max_m_(spec.range_max_m > 0 ? spec.range_max_m : std::numeric_limits<double>::infinity()) {}

 private:
  double value(const SensorInput& input) const override {
    const Pose sensor = world_from_sensor(input, body_from_sensor_);
    return input.scene.cast({sensor.position_m, -Eigen::Vector3d::UnitZ()}, range_max_m_).distance_m;
  }
  Pose body_from_sensor_;
  double range_max_m_;
};

}  // namespace

std::unique_ptr<Sensor> make_altitude(const SensorSpec& spec) { return std::make_unique<Altitude>(spec); }

}  // namespace uwsim
