#include <cmath>
#include <complex>
#include <numbers>
#include <optional>
#include <span>

#include "uwsim/acoustics/modem/arrival_cells.h"
#include "uwsim/acoustics/sound_path.h"
#include "uwsim/core/infinity.h"
#include "uwsim/rays/bed_depth.h"
#include "uwsim/sensors/mounted_sensor.h"

namespace uwsim {
namespace {

/// Acoustic position fix by an ultra-short baseline system at the station. The vehicle pings at the time of the sample;
/// the station measures travel time and direction and sends the fix back, which arrives after twice the travel time.
/// The station locks on to one arrival: the first within 20 dB of the strongest, or the strongest (`hears_strongest`).
/// Arrivals are computed between a flat surface and a flat bed of silt, at the depth of the bed half-way; obstacles do
/// not block them.
///
/// The station is assumed to know the sound-speed profile and to trace the ray that it measured back through it, as
/// long-range systems do when they have one (Kongsberg HiPAP: product description 317748/F, sec. 9.2), but not to know
/// that a ray has bounced. Without errors, the fix from a ray that has not bounced is therefore the true position, and
/// the fix from a ray that has bounced is a ghost above the surface or below the bed. Arrivals that follow the locked
/// one by less than `resolution_s` overlap with it. The direction is then that of the gradient of the phase of their
/// sum, which a short baseline measures: the mean of the unit vectors along the arrivals, weighted by their complex
/// amplitudes at `frequency_hz` (interference of plane waves, derived here; valid for a baseline that is short compared
/// with the interference pattern). There is no fix (range 0, invalid) out of range, where no sound arrives, or where
/// these arrivals cancel to below a tenth of the amplitude of the locked one.
///
/// The range error acts along the line of sight, and so does `scale`, the relative error of the speed of sound that the
/// station uses. The bearing error is two small angles across it, which cause an error
/// of R x angle in position. The fix carries the place of the station, as its own navigation has it, with the errors of
/// the channel `station`: of a survey, or of the boat that carries it. If `shares_modem` is set and the link uses
/// modems, ping and fix are sent as packets over the link instead (sim/position_exchange.h).
class Usbl final : public MountedSensor {
 public:
  explicit Usbl(const SensorSpec& spec)
      : MountedSensor(spec),
        range_max_m_(spec.number("range_max_m")),
        frequency_hz_(spec.number("frequency_hz")),
        resolution_s_(spec.number("resolution_s")),
        hears_strongest_(flag(spec.parameters, "hears_strongest")),
        shares_modem_(flag(spec.parameters, "shares_modem")) {}

  void observe(const SensorInput& input, std::span<double> raw) const override {
    const Eigen::Vector3d line = from_station(input);
    const bool in_range = line.norm() <= range_max_m_;
    const std::optional<Eigen::Vector3d> fix = in_range ? fix_from(line, input) : std::nullopt;
    const Eigen::Vector3d seen = fix.value_or(line);
    raw[0] = seen.norm();
    raw[1] = raw[2] = raw[kScale] = 0;
    Eigen::Vector3d::Map(&raw[kSight]) = raw[0] > 0 ? (seen / raw[0]).eval() : -Eigen::Vector3d::UnitZ().eval();
    raw[kFound] = fix.has_value();
    Eigen::Vector3d::Map(&raw[kStation]) = input.vehicle.station_world_m;
  }

  bool report(std::span<const double> raw, std::span<double> reading) const override {
    const bool in_range = raw[kFound] > 0;
    const double range_m = (1 + raw[kScale]) * raw[0];
    const Eigen::Vector3d sight = Eigen::Vector3d::Map(&raw[kSight]);
    const Eigen::Vector3d across =
        (std::hypot(sight.x(), sight.y()) > 1e-9 ? Eigen::Vector3d(-sight.y(), sight.x(), 0).normalized()
                                                 : Eigen::Vector3d::UnitY().eval());
    const Eigen::Vector3d measured =
        (sight + std::tan(raw[1]) * across + std::tan(raw[2]) * sight.cross(across)).normalized();
    Eigen::Vector3d::Map(&reading[0]) = in_range ? (range_m * measured).eval() : Eigen::Vector3d::Zero().eval();
    reading[3] = in_range ? range_m : 0;
    reading[4] = in_range ? std::atan2(measured.y(), measured.x()) : 0;
    reading[5] = in_range ? std::asin(std::clamp(measured.z(), -1.0, 1.0)) : 0;
    Eigen::Vector3d::Map(&reading[6]) = Eigen::Vector3d::Map(&raw[kStation]);
    return in_range;
  }

  double travel_time_s(const SensorInput& input) const override {
    const Eigen::Vector3d line = from_station(input);
    const auto found = line.norm() <= range_max_m_ ? arrivals_at_station(line, input) : std::span<const Arrival>();
    if (!found.empty()) return 2 * found[locked(found)].time_s;
    // After this time, no reply can arrive.
    return 2 * std::min(line.norm(), range_max_m_) / input.around.sound.at(depth_m(input.vehicle.station_world_m));
  }

  double longest_travel_time_s() const override { return 2 * range_max_m_ / kSlowestSound_m_s; }
  bool shares_modem() const override { return shares_modem_; }

 private:
  static constexpr std::size_t kScale = 3, kStation = 4, kSight = 7, kFound = 10;
  static constexpr double kSlowestSound_m_s = 1000;  // no water is slower (fresh water at 0 deg C: 1402 m/s)

  Eigen::Vector3d from_station(const SensorInput& input) const {
    return world_from_sensor(input).position_m - input.vehicle.station_world_m;
  }
  static double depth_m(const Eigen::Vector3d& point_world_m) { return std::max(0.0, -point_world_m.z()); }
  /// An end above the water is treated as if it were at the surface.
  std::span<const Arrival> arrivals_at_station(const Eigen::Vector3d& line, const SensorInput& input) const {
    const Surroundings& around = input.around;
    const Eigen::Vector3d &station = input.vehicle.station_world_m, middle = station + 0.5 * line;
    const double to_m = depth_m(station), from_m = depth_m(station + line);
    const RayScene fixed = around.scene.with(nullptr).with_plants(nullptr);  // the rest moves until the fix is read
    const double bed_m = bed_depth_m(fixed, middle.x(), middle.y());
    const double waves_m = around.water.waves ? 0.25 * around.water.waves->significant_height_m() : 0;
    const RayEnds ends{from_m, to_m, std::hypot(line.x(), line.y()),
                       bed_m > std::max(from_m, to_m) ? bed_m : kInfinity};
    return cells_.at(around.sound, ends, {frequency_hz_, kSilt, waves_m});
  }
  /// The arrival that the station locks on to, among arrivals sorted by level. If several arrive together, like the
  /// direct and the reflected sound near the surface, it is the one with the fewest bounces.
  std::size_t locked(std::span<const Arrival> found) const {
    const auto bounces = [&](std::size_t k) { return found[k].surface_bounces + found[k].bottom_bounces; };
    std::size_t chosen = 0, least = 0;
    for (std::size_t k = 1; k < found.size() && !hears_strongest_; ++k) {
      if (found[k].level_db >= found[0].level_db - kAudible_db && found[k].time_s < found[chosen].time_s) chosen = k;
    }
    least = chosen;
    for (std::size_t k = 0; k < found.size(); ++k) {
      const bool together = std::abs(found[k].time_s - found[chosen].time_s) <= kTogether * found[chosen].time_s;
      if (together && found[k].level_db >= found[chosen].level_db - kAlike_db && bounces(k) < bounces(least)) least = k;
    }
    return least;
  }
  /// The vehicle's position relative to the station, as the station would compute it without measurement errors.
  std::optional<Eigen::Vector3d> fix_from(const Eigen::Vector3d& line, const SensorInput& input) const {
    const std::span<const Arrival> found = arrivals_at_station(line, input);
    if (found.empty()) return std::nullopt;
    const Arrival& heard = found[locked(found)];
    std::complex<double> sum = 0, across = 0, down = 0;  // along the direction of travel
    bool alone = true;
    for (const Arrival& one : found) {
      const double late_s = one.time_s - heard.time_s;
      if (late_s < 0 || late_s > resolution_s_) continue;
      const double phase = 2 * std::numbers::pi * frequency_hz_ * late_s + one.phase_rad - heard.phase_rad;
      const auto part = std::polar(std::pow(10, 0.05 * (one.level_db - heard.level_db)), phase);
      alone = alone && &one == &heard;
      sum += part;
      across += part * std::cos(one.arrival_dip_rad);
      down += part * std::sin(one.arrival_dip_rad);
    }
    if (std::abs(sum) < kFaded) return std::nullopt;
    if (alone && heard.surface_bounces + heard.bottom_bounces == 0) return line;
    // Back along the ray, up if it came down
    const double dip = -std::atan2((down / sum).real(), std::max(0.0, (across / sum).real()));
    const double from_m = depth_m(input.vehicle.station_world_m);
    SoundState end = travel(input.around.sound, from_m, dip, heard.time_s);
    const double beyond_m = (heard.time_s - end.time_s) * input.around.sound.at(0);  // straight on above the surface
    const double far_m = end.across_m + beyond_m * std::cos(end.dip_rad);
    const double lower_m = end.depth_m - from_m + beyond_m * std::sin(end.dip_rad);
    const double level_m = std::hypot(line.x(), line.y());
    const Eigen::Vector3d level =
        level_m > 0 ? Eigen::Vector3d(line.x() / level_m, line.y() / level_m, 0) : Eigen::Vector3d::UnitX().eval();
    return (far_m * level - lower_m * Eigen::Vector3d::UnitZ()).eval();
  }

  static constexpr double kAudible_db = 20, kFaded = 0.1;
  static constexpr double kTogether = 1.0 / 8192, kAlike_db = 3;  // the accuracy of ArrivalCells
  static constexpr FluidBottom kSilt{1.7, 1.05, 1.0};             // Jensen et al. 2011, as for the link

  double range_max_m_, frequency_hz_, resolution_s_;
  bool hears_strongest_, shares_modem_;
  mutable ArrivalCells cells_{8};  // its results do not depend on which cells it holds
};

constexpr Field kUsblFields[] = {{"position_m", 3, "m"},
                                 {"range_m", 1, "m"},
                                 {"azimuth_rad", 1, "rad"},
                                 {"elevation_rad", 1, "rad"},
                                 {"station_world_m", 3, "m"}};
constexpr Channel kUsblChannels[] = {{"range", 1, "m"}, {"bearing", 2, "rad"}, {"scale", 1, "1"}, {"station", 3, "m"}};
constexpr Parameter kUsblParameters[] = {
    {"range_max_m", 1, 1000, 1, 10000, "m", "from the station; no fix beyond"},
    {"frequency_hz", 1, 25000, 1000, 1e6, "Hz", "centre of the band"},
    {"resolution_s", 1, 0, 0, 1, "s", "arrivals that follow within this time overlap with the one that is measured"},
    {"hears_strongest", 1, 0, 0, 1, "", "whether it measures the strongest arrival instead of the first",
     ParameterType::kFlag},
    {"shares_modem", 1, 1, 0, 1, "", "whether pings and fixes are packets of the link, where that has modems",
     ParameterType::kFlag}};

}  // namespace

extern const SensorKind kUsbl;
constinit const SensorKind kUsbl = {
    "usbl",
    "position from the station (world axes), range, azimuth from east to north, elevation; the station's place",
    kUsblFields,
    kUsblChannels,
    4,
    kUsblParameters,
    make_sensor<Usbl>};

}  // namespace uwsim
