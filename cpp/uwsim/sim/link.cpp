#include "uwsim/sim/link.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "uwsim/core/check.h"
#include "uwsim/core/infinity.h"
#include "uwsim/rays/ray_lanes.h"
#include "uwsim/rays/ray_packet.h"
#include "uwsim/sonar/water_sound.h"

namespace uwsim {
namespace {

constexpr int kChords = 4;  // number of chords per bent ray, for detecting obstacles
// A ray reflected by the flat bottom is checked for obstacles with its reflection raised by this fraction of the water
// depth.
constexpr double kOffTheBed = 0.05;
constexpr double kAudible_db = 20;     // weaker than the strongest by more than this does not count (reception.h)
constexpr double kBesideHit_m = 0.01;  // step past a solid before continuing behind it
constexpr int kSolidsPassed = 8;
constexpr double kDeepestBed_m = 12000;

double depth_of(const Transducer& transducer) { return std::max(0.0, -transducer.position_world_m.z()); }

Eigen::Vector3d along(const Eigen::Vector3d& level, double dip_rad) {
  return std::cos(dip_rad) * level - std::sin(dip_rad) * Eigen::Vector3d::UnitZ();
}

/// Adds the segments of a ray. A straight ray consists of the lines between its reflections. The legs of a bent ray are
/// approximated by chords between its reflections and turning points; one without reflections and with at most one
/// turning point, by chords of the cubic that has the same ends and the same directions there.
void add_segments(const Arrival& ray, bool bends, const Transducer& from, const Transducer& to,
                  const Eigen::Vector3d& level, std::size_t path, std::vector<RaySegment>& segments) {
  const double start_m = depth_of(from), end_m = depth_of(to);
  const Eigen::Vector3d line = to.position_world_m - from.position_world_m;
  const double across_m = std::hypot(line.x(), line.y());
  Eigen::Vector3d last = from.position_world_m;
  const auto go = [&](const Eigen::Vector3d& point) {
    segments.push_back({last, point, path});
    last = point;
  };
  const auto at = [&](double x_m, double depth_m) {
    return Eigen::Vector3d(from.position_world_m + x_m * level + (start_m - depth_m) * Eigen::Vector3d::UnitZ());
  };
  if (ray.surface_bounces + ray.bottom_bounces == 0 && ray.turns <= 1) {
    const double down = across_m * std::tan(ray.launch_dip_rad), up = across_m * std::tan(ray.arrival_dip_rad);
    for (int k = 1; k < kChords && bends; ++k) {
      const double t = static_cast<double>(k) / kChords, u = 1 - t;
      const double depth_m =
          u * u * (1 + 2 * t) * start_m + u * u * t * down + t * t * (3 - 2 * t) * end_m - t * t * u * up;
      go(at(t * across_m, std::max(0.0, depth_m)));
    }
  } else {
    const int reversals = ray.legs() - 1;
    const double whole_m = ray.first_m + (reversals - 1) * ray.crossing_m + ray.last_m;
    const double lowest_m = ray.bottom_bounces > 0 ? (1 - kOffTheBed) * ray.bottom_m : ray.bottom_m;
    bool is_up = ray.launch_dip_rad < 0;
    for (int k = 0; k < reversals; ++k, is_up = !is_up) {
      go(at(across_m * (ray.first_m + k * ray.crossing_m) / whole_m, is_up ? ray.top_m : lowest_m));
    }
  }
  go(to.position_world_m);
}

/// Whether terrain blocks a segment behind the solid that the segment hits first.
bool blocked_behind(const RayScene& scene, const RaySegment& segment, double beyond_m) {
  const Eigen::Vector3d line = (segment.to - segment.from).normalized();
  Eigen::Vector3d from = segment.from;
  for (int passed = 0; passed < kSolidsPassed; ++passed) {
    from += (beyond_m + kBesideHit_m) * line;
    const double length = (segment.to - from).dot(line);
    if (!(length > kBesideHit_m)) return false;
    const RayHit hit = scene.cast({from, line}, length);
    if (!(hit.distance_m < length)) return false;
    if (hit.label == kTerrain) return true;
    beyond_m = hit.distance_m;
  }
  return false;
}

/// Determines which paths are blocked by terrain. All segments are cast together, each only along its length.
std::vector<bool> blocked_paths(const RayScene& scene, const std::vector<RaySegment>& segments, std::size_t paths) {
  std::vector<bool> blocked(paths, false);
  for (std::size_t first = 0; first < segments.size(); first += kPacketRays) {
    const std::size_t count = std::min(kPacketRays, segments.size() - first);
    ExactRays rays;
    ExactHits hits;
    for (std::size_t lane = 0; lane < kPacketRays; ++lane) {
      const RaySegment& segment = segments[first + std::min(lane, count - 1)];
      const Eigen::Vector3d line = segment.to - segment.from;
      const double length = line.norm();
      const bool active = lane < count && length > 0;
      set_ray(rays, lane, segment.from, active ? Eigen::Vector3d(line / length) : -Eigen::Vector3d::UnitZ(), length,
              active);
    }
    scene.cast({&rays, 1}, {&hits, 1});
    for (std::size_t lane = 0; lane < count; ++lane) {
      const RaySegment& segment = segments[first + lane];
      if (!(hits.distance_m[lane] < (segment.to - segment.from).norm())) continue;
      if (hits.label[lane] == kTerrain || blocked_behind(scene, segment, hits.distance_m[lane])) {
        blocked[segment.path] = true;
      }
    }
  }
  return blocked;
}

/// The depths of the bed at evenly spaced places from one transducer to the other; infinite where there is none.
using BedProfile = std::array<double, 5>;

BedProfile bed_between(const RayScene& scene, const Transducer& from, const Transducer& to) {
  BedProfile bed_m;
  ExactRays rays;
  ExactHits hits;
  for (std::size_t lane = 0; lane < kPacketRays; ++lane) {
    const double share = static_cast<double>(std::min(lane, bed_m.size() - 1)) / static_cast<double>(bed_m.size() - 1);
    Eigen::Vector3d above = from.position_world_m + share * (to.position_world_m - from.position_world_m);
    above.z() = 0;
    set_ray(rays, lane, above, -Eigen::Vector3d::UnitZ(), kDeepestBed_m, lane < bed_m.size());
  }
  scene.cast({&rays, 1}, {&hits, 1});
  std::copy_n(hits.distance_m.begin(), bed_m.size(), bed_m.begin());
  return bed_m;
}

/// By how much a bed departs from a depth, as a part of it; 1 where it is missing.
double departure(const BedProfile& bed_m, double bottom_m) {
  double most = 0;
  for (const double depth_m : bed_m) {
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

Reception LinkWater::hear(const RayScene& scene, const Transducer& from, const Transducer& to) const {
  const Eigen::Vector3d line = to.position_world_m - from.position_world_m;
  if (modem_.kind == LinkKind::kCable) return perfect(modem_.latency_s);
  if (modem_.kind == LinkKind::kIdeal) return perfect(line.norm() * slowness_s_m(depth_of(from), depth_of(to)));
  if (from.position_world_m.z() > 0 || to.position_world_m.z() > 0) return {};  // one of the transducers is in the air
  const double across_m = std::hypot(line.x(), line.y());
  const Eigen::Vector3d level =
      across_m > 0 ? Eigen::Vector3d(line.x() / across_m, line.y() / across_m, 0) : Eigen::Vector3d(1, 0, 0);
  const double deepest = std::max(depth_of(from), depth_of(to));
  const BedProfile bed_m = bed_between(scene, from, to);
  double bottom_m = bed_m[bed_m.size() / 2];
  // The bed half-way is above one of the ends, so there is no reflection
  if (bottom_m <= deepest) bottom_m = kInfinity;
  const SoundLosses losses{modem_.frequency_hz, water_.bottom, water_.surface_rms_m, &water_.absorption};
  const std::span<const Arrival> rays =
      cells_.at(water_.profile, {depth_of(from), depth_of(to), across_m, bottom_m}, losses);
  const bool bends = water_.profile.steepest_1_s() > 0;
  paths_.clear();
  double strongest_db = -1e9;
  bool bounces = false;
  // Strongest first, until terrain blocks none that counts
  for (std::size_t first = 0, end = 0; first < rays.size(); first = end) {
    if (rays[first].level_db < strongest_db - kAudible_db) break;
    segments_.clear();
    for (; end < rays.size() && rays[end].level_db >= rays[first].level_db - kAudible_db; ++end) {
      add_segments(rays[end], bends, from, to, level, end - first, segments_);
    }
    const std::vector<bool> blocked = blocked_paths(scene, segments_, end - first);
    for (std::size_t k = first; k < end; ++k) {
      if (blocked[k - first]) continue;
      const Arrival& ray = rays[k];
      strongest_db = std::max(strongest_db, ray.level_db);
      bounces |= ray.bottom_bounces > 0 && ray.level_db >= strongest_db - kAudible_db;
      paths_.push_back({ray.time_s, modem_.source_level_db + ray.level_db,
                        from.velocity_world_m_s.dot(along(level, ray.launch_dip_rad)) -
                            to.velocity_world_m_s.dot(along(level, ray.arrival_dip_rad))});
    }
  }
  Reception heard = reception(modem_, water_, paths_);
  if (bounces) heard.bed_departure = departure(bed_m, bottom_m);
  return heard;
}

std::array<double, 2> LinkWater::overhear(const Transducer& from, const Transducer& to) const {
  const double length_m = (to.position_world_m - from.position_world_m).norm();
  if (from.position_world_m.z() > 0 || to.position_world_m.z() > 0) return {0, -300};
  const double middle_m = 0.5 * (depth_of(from) + depth_of(to));
  return {length_m / water_.profile.at(middle_m),
          modem_.source_level_db - spherical_loss_db(water_, length_m, middle_m)};
}

}  // namespace uwsim
