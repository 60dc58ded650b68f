#include "uwsim/sim/link.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "uwsim/core/check.h"
#include "uwsim/core/infinity.h"
#include "uwsim/sonar/water_sound.h"

namespace uwsim {
namespace {

// When a ray reflected by the flat bottom is compared with the bed, its reflection point is raised by this fraction of
// the depth.
constexpr double kOffTheBed = 0.05;
constexpr double kAudible_db = 20;  // arrivals weaker than the strongest by more than this are ignored (reception.h)
constexpr std::size_t kQuarters = 4;

double depth_of(const Transducer& transducer) { return std::max(0.0, -transducer.position_world_m.z()); }

Eigen::Vector3d along(const Eigen::Vector3d& level, double dip_rad) {
  return std::cos(dip_rad) * level - std::sin(dip_rad) * Eigen::Vector3d::UnitZ();
}

/// Sets the depths of the bed at evenly spaced points from one transducer to the other, both included; infinite where
/// there is no bed. The number of points is 1 more than a multiple of four. Their spacing is the radius of the first
/// Fresnel zone half-way, sqrt(wavelength range) / 2, or the width of the terrain's cells if that is larger: narrower
/// features do not block sound.
void sound_bed(const RayScene& scene, const Transducer& from, const Transducer& to, double wavelength_m,
               std::vector<double>& bed_m) {
  const Eigen::Vector3d line = to.position_world_m - from.position_world_m;
  const Heightfield* terrain = scene.terrain();
  const double across_m = line.head<2>().norm(), zone_m = 0.5 * std::sqrt(wavelength_m * across_m);
  const double parts = terrain && across_m > 0 ? across_m / std::max(zone_m, terrain->spacing_m()) : 0;
  const double places = kQuarters * std::max(1.0, std::ceil(parts / kQuarters));
  bed_m.assign(static_cast<std::size_t>(places) + 1, kInfinity);
  for (std::size_t k = 0; terrain && k < bed_m.size(); ++k) {
    const Eigen::Vector3d place = from.position_world_m + static_cast<double>(k) / places * line;
    const double height_m = terrain->height_at(place.x(), place.y());
    if (std::isfinite(height_m)) bed_m[k] = -height_m;  // NaN outside the terrain
  }
}

/// The shape of a ray between two transducers, for testing whether terrain blocks it. A straight ray consists of the
/// lines between its reflections. A bent ray is approximated by lines between its reflections and turning points or, if
/// it has no reflections and at most one turning point, by the cubic that has the same ends and directions there.
struct RayPath {
  const Arrival& ray;
  bool bends;
  double start_m, end_m, across_m;  // depths of the ends, and the distance between them

  /// Whether the bed is above the ray at any of the points.
  bool is_blocked(std::span<const double> bed_m) const {
    const auto places = static_cast<double>(bed_m.size() - 1);
    const auto meets_bed = [&](double first, double last, const auto& depth_at) {
      for (auto k = static_cast<std::size_t>(std::ceil(first * places)); static_cast<double>(k) <= last * places; ++k) {
        if (depth_at(static_cast<double>(k) / places) > bed_m[k]) return true;
      }
      return false;
    };
    if (bends && ray.surface_bounces + ray.bottom_bounces == 0 && ray.turns <= 1) {
      const double down = across_m * std::tan(ray.launch_dip_rad), up = across_m * std::tan(ray.arrival_dip_rad);
      return meets_bed(0, 1, [&](double t) {
        const double u = 1 - t;
        return u * u * (1 + 2 * t) * start_m + u * u * t * down + t * t * (3 - 2 * t) * end_m - t * t * u * up;
      });
    }
    const int reversals = ray.legs() - 1;
    const double whole_m = ray.first_m + (reversals - 1) * ray.crossing_m + ray.last_m;
    const double lowest_m = ray.bottom_bounces > 0 ? (1 - kOffTheBed) * ray.bottom_m : ray.bottom_m;
    bool is_up = ray.launch_dip_rad < 0;
    double from = 0, from_depth_m = start_m;
    for (int k = 0; k <= reversals; ++k, is_up = !is_up) {
      const double to = k == reversals ? 1 : whole_m > 0 ? (ray.first_m + k * ray.crossing_m) / whole_m : 0;
      const double to_depth_m = k == reversals ? end_m : is_up ? ray.top_m : lowest_m;
      const double slope_m = to > from ? (to_depth_m - from_depth_m) / (to - from) : 0;
      if (meets_bed(from, to, [&](double t) { return from_depth_m + (t - from) * slope_m; })) return true;
      from = to, from_depth_m = to_depth_m;
    }
    return false;
  }
};

/// The largest departure of the bed at the ends, half-way and in between from a depth, as a fraction of that depth; 1
/// where there is no bed.
double departure(std::span<const double> bed_m, double bottom_m) {
  double most = 0;
  for (std::size_t quarter = 0; quarter <= kQuarters; ++quarter) {
    const double depth_m = bed_m[quarter * (bed_m.size() - 1) / kQuarters];
    most = std::max(most, std::isfinite(depth_m) ? std::abs(depth_m / bottom_m - 1) : 1.0);
  }
  return most;
}

Reception perfect(double delay_s) { return {.reached = true, .delay_s = delay_s, .signal_db = 0, .noise_db = 0}; }

ModemWater modem_water(const LinkSpec& spec, const Water& water) {
  const bool is_modem = spec.modem.kind == LinkKind::kModem;
  const double frequency = is_modem ? spec.modem.frequency_hz : 1e4;
  return {sound_speed_profile(water), absorption_column(water, frequency, spec.acidity_ph, water.bottom_depth_m),
          spec.bottom, water.waves ? 0.25 * water.waves->significant_height_m() : 0,
          ambient_noise_db_hz(frequency, spec.noise)};
}

}  // namespace

void LinkSpec::check() const {
  modem.check();
  require(station_transducer_world_m.allFinite() && station_transducer_world_m.z() <= 0, "link.station_transducer_m",
          station_transducer_world_m.transpose(), "must be finite and under water");
  require(noise.wind_m_s >= 0 && noise.wind_m_s <= 40, "link.wind_m_s", noise.wind_m_s, "must be in [0, 40] m/s");
  require(noise.shipping >= 0 && noise.shipping <= 1, "link.shipping", noise.shipping, "must be in [0, 1]");
  require(acidity_ph >= 6 && acidity_ph <= 9, "link.acidity_ph", acidity_ph, "must be in [6, 9]");
  for (const LinkFault& fault : faults) {
    require(fault.until_s > fault.from_s, "link.faults.until_s", fault.until_s, "must be after from_s");
    require(fault.loss > 0 && fault.loss <= 1, "link.faults.loss", fault.loss, "must be in (0, 1]");
  }
}

LinkWater::LinkWater(const LinkSpec& spec, const Water& water)
    : modem_(spec.modem), water_(modem_water(spec, water)), cells_(256) {}

double LinkWater::slowness_s_m(double from_depth_m, double to_depth_m) const {
  constexpr int kParts = 8;
  double sum = 0;
  for (int part = 0; part < kParts; ++part) {
    sum += 1 / water_.profile.at(from_depth_m + (to_depth_m - from_depth_m) * (part + 0.5) / kParts);
  }
  return sum / kParts;
}

Reception LinkWater::receive(const RayScene& scene, const Transducer& from, const Transducer& to) const {
  const Eigen::Vector3d line = to.position_world_m - from.position_world_m;
  if (modem_.kind == LinkKind::kCable) return perfect(modem_.latency_s);
  if (modem_.kind == LinkKind::kIdeal) return perfect(line.norm() * slowness_s_m(depth_of(from), depth_of(to)));
  if (from.position_world_m.z() > 0 || to.position_world_m.z() > 0) return {};  // one of the transducers is in the air
  const double across_m = std::hypot(line.x(), line.y());
  const Eigen::Vector3d level =
      across_m > 0 ? Eigen::Vector3d(line.x() / across_m, line.y() / across_m, 0) : Eigen::Vector3d(1, 0, 0);
  const double deepest = std::max(depth_of(from), depth_of(to));
  sound_bed(scene, from, to, water_.profile.at(0) / modem_.frequency_hz, bed_m_);
  double bottom_m = bed_m_[bed_m_.size() / 2];
  // The bed half-way is above one of the ends, so there is no reflection
  if (bottom_m <= deepest) bottom_m = kInfinity;
  const SoundLosses losses{modem_.frequency_hz, water_.bottom, water_.surface_rms_m, &water_.absorption};
  const std::span<const Arrival> rays =
      cells_.at(water_.profile, {depth_of(from), depth_of(to), across_m, bottom_m}, losses);
  const bool bends = water_.profile.steepest_1_s() > 0;
  paths_.clear();
  double strongest_db = -1e9;
  bool bounces = false;
  for (const Arrival& ray : rays) {
    if (ray.level_db < strongest_db - kAudible_db) continue;
    if (RayPath{ray, bends, depth_of(from), depth_of(to), across_m}.is_blocked(bed_m_)) continue;
    strongest_db = std::max(strongest_db, ray.level_db);
    bounces |= ray.bottom_bounces > 0 && ray.level_db >= strongest_db - kAudible_db;
    paths_.push_back({ray.time_s, modem_.source_level_db + ray.level_db,
                      from.velocity_world_m_s.dot(along(level, ray.launch_dip_rad)) -
                          to.velocity_world_m_s.dot(along(level, ray.arrival_dip_rad))});
  }
  Reception heard = reception(modem_, water_, paths_);
  if (bounces) heard.bed_departure = departure(bed_m_, bottom_m);
  return heard;
}

std::array<double, 2> LinkWater::interference(const Transducer& from, const Transducer& to) const {
  const double length_m = (to.position_world_m - from.position_world_m).norm();
  if (from.position_world_m.z() > 0 || to.position_world_m.z() > 0) return {0, -300};
  const double middle_m = 0.5 * (depth_of(from) + depth_of(to));
  return {length_m / water_.profile.at(middle_m),
          modem_.source_level_db - spherical_loss_db(water_, length_m, middle_m)};
}

}  // namespace uwsim
