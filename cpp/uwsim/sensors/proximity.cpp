#include <algorithm>

#include "uwsim/core/check.h"
#include "uwsim/sensors/kinds.h"
#include "uwsim/sensors/scalar_sensor.h"

namespace uwsim {
namespace {

/// Distance along the sensor's x axis to the nearest thing [m]; its range where nothing is nearer, as published.
class Proximity final : public ScalarSensor {
 public:
  explicit Proximity(const SensorSpec& spec)
      : ScalarSensor("range_m"), body_from_sensor_(spec.body_from_sensor), range_max_m_(spec.range_max_m) {
    require(range_max_m_ > 0, "sensors." + spec.name + ".range_max_m", range_max_m_, "must be positive");
  }

 private:
  double value(const SensorInput& input) const override {
    const Pose sensor = world_from_sensor(input, body_from_sensor_);
    const RayHit hit = input.scene.cast({sensor.position_m, sensor.direction(Eigen::Vector3d::UnitX())}, range_max_m_);
    const double hit_z = sensor.position_m.z() + hit.distance_m * sensor.direction(Eigen::Vector3d::UnitX()).z();
    const bool under_water = sensor.position_m.z() <= 0 && hit_z <= 0;  // sound does not leave the water
    return under_water ? std::min(hit.distance_m, range_max_m_) : range_max_m_;
  }
  Pose body_from_sensor_;
  double range_max_m_;
};

}  // namespace

std::unique_ptr<Sensor> make_proximity(const SensorSpec& spec) { return std::make_unique<Proximity>(spec); }

}  // namespace uwsim
