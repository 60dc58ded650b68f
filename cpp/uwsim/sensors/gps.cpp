#include <cmath>
#include <limits>

#include "uwsim/sensors/mounted_sensor.h"

namespace uwsim {
namespace {

constexpr double kUnderWater = -1;

/// A satellite receiver whose antenna is the sensor's position. Sea water absorbs the signals within millimetres, so
/// there is no fix while the antenna is below the surface, waves included. A fix returns when the antenna has been
/// clear at every sample for `reacquisition_s`, or for `cold_start_s` after an outage longer than `ephemeris_s`, when
/// the satellites' orbits must be received again.
class Gps final : public MountedSensor {
 public:
  explicit Gps(const SensorSpec& spec)
      : MountedSensor(spec),
        reacquisition_s_(spec.number("reacquisition_s")),
        cold_start_s_(spec.number("cold_start_s")),
        ephemeris_s_(spec.number("ephemeris_s")) {}

  void observe(const SensorInput& input, std::span<double> raw) const override {
    const Eigen::Vector3d antenna = world_from_sensor(input).position_m;
    Eigen::Vector3d::Map(&raw[0]) = antenna;
    Eigen::Vector3d::Map(&raw[3]) = input.vehicle.state.world_from_body.direction(velocity_body_m_s(input));
    const bool clear = antenna.z() > input.around.water.surface_height_at(antenna.x(), antenna.y(), input.time_s);
    raw[6] = clear ? std::numeric_limits<double>::infinity() : kUnderWater;
    raw[7] = 0;
  }

  bool remembers() const override { return true; }
  /// raw[6]: time since the antenna came out of the water, infinite if it was never under it; raw[7]: length of the
  /// last outage. A receiver that begins under water had a fix before.
  void follow(const SensorInput&, const Past& past, std::span<double> raw) const override {
    if (past.raw.empty()) return;
    const bool is_clear = raw[6] != kUnderWater, was_clear = past.raw[6] != kUnderWater;
    if (is_clear) raw[6] = was_clear ? past.raw[6] + past.elapsed_s : 0;
    raw[7] = past.raw[7];
    if (!was_clear) raw[7] += past.elapsed_s;
    if (was_clear && !is_clear) raw[7] = 0;
  }

  bool report(std::span<const double> raw, std::span<double> reading) const override {
    const bool fix = raw[6] >= (raw[7] > ephemeris_s_ ? cold_start_s_ : reacquisition_s_);
    for (std::size_t k = 0; k < 6; ++k) reading[k] = fix ? raw[k] : std::numeric_limits<double>::quiet_NaN();
    reading[6] = fix;
    return fix;
  }

 private:
  double reacquisition_s_, cold_start_s_, ephemeris_s_;
};

constexpr Field kGpsFields[] = {{"position_m", 3, "m"}, {"velocity_m_s", 3, "m/s"}, {"fix", 1, "1"}};
constexpr Channel kGpsChannels[] = {{"horizontal", 2, "m"}, {"vertical", 1, "m"}, {"velocity", 3, "m/s"}};
constexpr Parameter kGpsParameters[] = {
    {"reacquisition_s", 1, 1, 0, 3600, "s", "of clear sky until a fix returns"},
    {"cold_start_s", 1, 26, 0, 3600, "s", "the same after an outage longer than ephemeris_s"},
    {"ephemeris_s", 1, 14400, 0, 1e9, "s", "for which the orbits that a receiver has are good"}};

}  // namespace

extern const SensorKind kGps;
constinit const SensorKind kGps = {
    "gps",
    "position and velocity of a satellite receiver's antenna (world axes), fix (1 or 0); NaN without a fix",
    kGpsFields,
    kGpsChannels,
    2,
    kGpsParameters,
    make_sensor<Gps>};

}  // namespace uwsim
