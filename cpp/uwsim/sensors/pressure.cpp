#include "uwsim/sensors/mounted_sensor.h"

namespace uwsim {
namespace {

/// Absolute pressure due to the atmosphere and the water, including its density profile and waves.
class Pressure final : public MountedSensor {
 public:
  explicit Pressure(const SensorSpec& spec) : MountedSensor(spec) {}

  void observe(const SensorInput& input, std::span<double> raw) const override {
    raw[0] = input.around.water.pressure_pa(world_from_sensor(input).position_m, input.time_s);
  }
};

constexpr Field kPressureFields[] = {{"pressure_pa", 1, "Pa"}};
constexpr Channel kPressureChannels[] = {{"pressure", 1, "Pa"}};

}  // namespace

extern const SensorKind kPressure;
constinit const SensorKind kPressure = {"pressure", "absolute pressure",  kPressureFields, kPressureChannels, 0,
                                        {},         make_sensor<Pressure>};

}  // namespace uwsim
