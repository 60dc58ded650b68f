#include "uwsim/sensors/mounted.h"

namespace uwsim {
namespace {

/// Absolute pressure: the atmosphere's and the water's own, with its density profile and its waves.
class Pressure final : public Mounted {
 public:
  explicit Pressure(const SensorSpec& spec) : Mounted(spec) {}

  void observe(const SensorInput& input, std::span<double> raw) const override {
    raw[0] = input.around.water.pressure_pa(world_from_sensor(input).position_m, input.time_s);
  }
};

constexpr Field kFields[] = {{"pressure_pa", 1, "Pa"}};
constexpr Channel kChannels[] = {{"pressure", 1, "Pa"}};

}  // namespace

extern const SensorKind kPressure;
constinit const SensorKind kPressure = {"pressure", "absolute pressure",  kFields, kChannels, 0,
                                        {},         make_sensor<Pressure>};

}  // namespace uwsim
