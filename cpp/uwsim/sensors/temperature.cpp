#include "uwsim/sensors/mounted_sensor.h"

namespace uwsim {
namespace {

/// Water temperature at the sensor.
class Temperature final : public MountedSensor {
 public:
  explicit Temperature(const SensorSpec& spec) : MountedSensor(spec) {}

  void observe(const SensorInput& input, std::span<double> raw) const override {
    raw[0] = input.around.water.temperature_deg_c(world_from_sensor(input).position_m, input.time_s);
  }
};

constexpr Field kTemperatureFields[] = {{"temperature_deg_c", 1, "deg C"}};
constexpr Channel kTemperatureChannels[] = {{"temperature", 1, "deg C"}};

}  // namespace

extern const SensorKind kTemperature;
constinit const SensorKind kTemperature = {
    "temperature", "water temperature", kTemperatureFields, kTemperatureChannels, 0, {}, make_sensor<Temperature>};

}  // namespace uwsim
