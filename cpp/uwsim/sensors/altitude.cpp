#include <cmath>

#include "uwsim/sensors/mounted.h"

namespace uwsim {
namespace {

/// Distance straight down (as of a stabilised altimeter) to whatever lies below, seabed or not. Past its range:
/// infinity and invalid; nearer than it can tell: its least range and invalid.
class Altitude final : public Mounted {
 public:
  explicit Altitude(const SensorSpec& spec)
      : Mounted(spec), range_min_m_(spec.number("range_min_m")), range_max_m_(spec.number("range_max_m")) {}

  void observe(const SensorInput& input, std::span<double> raw) const override {
    const Ray down{world_from_sensor(input).position_m, -Eigen::Vector3d::UnitZ()};
    raw[0] = input.around.scene.cast(down, range_max_m_).distance_m;
  }

  bool report(std::span<const double> raw, std::span<double> reading) const override {
    reading[0] = std::max(raw[0], range_min_m_);
    return std::isfinite(raw[0]) && raw[0] >= range_min_m_;
  }

 private:
  double range_min_m_, range_max_m_;
};

constexpr Field kFields[] = {{"altitude_m", 1, "m"}};
constexpr Channel kChannels[] = {{"altitude", 1, "m"}};
constexpr Parameter kParameters[] = {{"range_min_m", 1, 0, 0, 1000, "m", "nearer is invalid"},
                                     {"range_max_m", 1, 1000, 0.1, 1000, "m", "farther is invalid and infinity"}};

}  // namespace

extern const SensorKind kAltitude;
constinit const SensorKind kAltitude = {
    "altitude",           "distance straight down; infinity past its range", kFields, kChannels, 0, kParameters,
    make_sensor<Altitude>};

}  // namespace uwsim
