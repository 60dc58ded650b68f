#include "uwsim/sensors/mounted_sensor.h"

namespace uwsim {
namespace {

/// Depth as real depth sensors derive it: gauge pressure (zero at the surface) / (nominal density x gravity), positive
/// down, 0 in air. The reading is therefore inaccurate in stratified water and, because water is compressible and
/// gravity grows, too large by 2.4 m at 1000 m. Under waves, it follows the pressure.
class Depth final : public MountedSensor {
 public:
  explicit Depth(const SensorSpec& spec) : MountedSensor(spec), density_kg_m3_(spec.number("density_kg_m3")) {}

  void observe(const SensorInput& input, std::span<double> raw) const override {
    const Water& water = input.around.water;
    const double weight_n_m3 = water.gravity() * (density_kg_m3_ > 0 ? density_kg_m3_ : water.density_at(0));
    const double gauge_pa = water.gauge_pressure_at(world_from_sensor(input).position_m, input.time_s);
    raw[0] = weight_n_m3 > 0 ? gauge_pa / weight_n_m3 : 0;
  }

 private:
  double density_kg_m3_;
};

constexpr Field kDepthFields[] = {{"depth_m", 1, "m"}};
constexpr Channel kDepthChannels[] = {{"depth", 1, "m"}};
constexpr Parameter kDepthParameters[] = {
    {"density_kg_m3", 1, 0, 0, 1300, "kg/m3", "nominal density; 0: the water's own at the surface"}};

}  // namespace

extern const SensorKind kDepth;
constinit const SensorKind kDepth = {"depth",
                                     "depth below the surface inferred from pressure with a nominal density",
                                     kDepthFields,
                                     kDepthChannels,
                                     0,
                                     kDepthParameters,
                                     make_sensor<Depth>};

}  // namespace uwsim
