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

constexpr double kDeepest_m = 12000;
constexpr int kChords = 4;  // number of chords per bent ray, for detecting obstacles
// A ray reflected by the flat bottom is checked for obstacles with its reflection raised by this fraction of the water
// depth.
constexpr double kOffTheBed = 0.05;
constexpr double kBesideHit_m = 0.01;  // step past a solid before continuing behind it
constexpr int kSolidsPassed = 8;

double depth_of(const Transducer& transducer) { return std::max(0.0, -transducer.position_world_m.z()); }

Eigen::Vector3d along(const Eigen::Vector3d& level, double dip_rad) {
  return std::cos(dip_rad) * level - std::sin(dip_rad) * Eigen::Vector3d::UnitZ();
}

/// The depth of the first surface below a point; infinite if there is none.
double bed_under(const RayScene& scene, const Eigen::Vector3d& point_world_m) {
  const Eigen::Vector3d top(point_world_m.x(), point_world_m.y(), 0);
  return scene.cast({top, -Eigen::Vector3d::UnitZ()}, kDeepest_m).distance_m;
}

/// A straight segment of a ray's path.
struct Segment {
  Eigen::Vector3d from, to;
  std::size_t path;  // index of its path
};

/// Adds the segments of a ray. A straight ray consists of the lines between its reflections. A bent ray is approximated
/// by chords of the cubic that has the same ends and the same directions there.
void add_segments(const Eigenray& ray, bool bends, const Transducer& from, const Transducer& to,
                  const Eigen::Vector3d& level, double bottom_m, std::size_t path, std::vector<Segment>& segments) {
  const double start_m = depth_of(from), end_m = depth_of(to);
  Eigen::Vector3d last = from.position_world_m;
  const auto go = [&](const Eigen::Vector3d& point) {
    segments.push_back({last, point, path});
    last = point;
  };
  const auto at = [&](double across_m, double depth_m) {
    return Eigen::Vector3d(from.position_world_m + across_m * level + (start_m - depth_m) * Eigen::Vector3d::UnitZ());
  };
  if (ray.surface_bounces + ray.bottom_bounces == 0) {
    double across_m = 0;
    for (const double leg_m : ray.across_m) across_m += leg_m;
    const double down = across_m * std::tan(ray.launch_dip_rad), up = across_m * std::tan(ray.arrival_dip_rad);
    for (int k = 1; k < kChords && bends; ++k) {
      const double t = static_cast<double>(k) / kChords, u = 1 - t;
      const double depth_m =
          u * u * (1 + 2 * t) * start_m + u * u * t * down + t * t * (3 - 2 * t) * end_m - t * t * u * up;
      go(at(t * across_m, std::max(0.0, depth_m)));
    }
  } else {
    double across_m = 0;
    bool at_surface = ray.launch_dip_rad < 0;
    for (int k = 0; k + 1 < ray.legs; ++k, at_surface = !at_surface) {
      across_m += ray.across_m[static_cast<std::size_t>(k)];
      go(at(across_m, at_surface ? 0 : (1 - kOffTheBed) * bottom_m));
    }
  }
  go(to.position_world_m);
}

/// Whether terrain blocks a segment behind the solid that the segment hits first.
bool blocked_behind(const RayScene& scene, const Segment& segment, double beyond_m) {
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
std::vector<bool> blocked_paths(const RayScene& scene, const std::vector<Segment>& segments, std::size_t paths) {
  std::vector<bool> blocked(paths, false);
  for (std::size_t first = 0; first < segments.size(); first += kPacketRays) {
    const std::size_t count = std::min(kPacketRays, segments.size() - first);
    ExactRays rays;
    ExactHits hits;
    for (std::size_t lane = 0; lane < kPacketRays; ++lane) {
      const Segment& segment = segments[first + std::min(lane, count - 1)];
      const Eigen::Vector3d line = segment.to - segment.from;
      const double length = line.norm();
      const bool active = lane < count && length > 0;
      set_ray(rays, lane, segment.from, active ? Eigen::Vector3d(line / length) : -Eigen::Vector3d::UnitZ(), length,
              active);
    }
    scene.cast({&rays, 1}, {&hits, 1});
    for (std::size_t lane = 0; lane < count; ++lane) {
      const Segment& segment = segments[first + lane];
      if (!(hits.distance_m[lane] < (segment.to - segment.from).norm())) continue;
      if (hits.label[lane] == kTerrain || blocked_behind(scene, segment, hits.distance_m[lane])) {
        blocked[segment.path] = true;
      }
    }
  }
  return blocked;
}

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

LinkWater::LinkWater(const LinkSpec& spec, const Water& water) : modem_(spec.modem), water_(modem_water(spec, water)) {}

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
  Reception heard;
  heard.reached = true;
  heard.noise_db = 0;
  heard.signal_db = 0;
  if (modem_.kind == LinkKind::kCable) {
    heard.delay_s = modem_.latency_s;
    return heard;
  }
  if (modem_.kind == LinkKind::kIdeal) {
    heard.delay_s = line.norm() * slowness_s_m(depth_of(from), depth_of(to));
    return heard;
  }
  if (from.position_world_m.z() > 0 || to.position_world_m.z() > 0) return {};  // one of the transducers is in the air
  const double across_m = std::hypot(line.x(), line.y());
  const Eigen::Vector3d level =
      across_m > 0 ? Eigen::Vector3d(line.x() / across_m, line.y() / across_m, 0) : Eigen::Vector3d(1, 0, 0);
  const double deepest = std::max(depth_of(from), depth_of(to));
  double bottom_m = bed_under(scene, 0.5 * (from.position_world_m + to.position_world_m));
  // The bed half-way is above one of the ends, so there is no reflection
  if (bottom_m <= deepest) bottom_m = kInfinity;
  const std::vector<Eigenray> rays = eigenrays(water_.profile, {depth_of(from), depth_of(to), across_m, bottom_m});
  std::vector<Segment> segments;
  const bool bends = water_.profile.steepest_1_s() > 0;
  for (std::size_t k = 0; k < rays.size(); ++k) add_segments(rays[k], bends, from, to, level, bottom_m, k, segments);
  const std::vector<bool> blocked = blocked_paths(scene, segments, rays.size());
  std::vector<HeardPath> paths;
  for (std::size_t k = 0; k < rays.size(); ++k) {  // sorted by travel time
    if (blocked[k]) continue;
    const Eigenray& ray = rays[k];
    if (paths.empty()) {
      heard.closing_m_s = from.velocity_world_m_s.dot(along(level, ray.launch_dip_rad)) -
                          to.velocity_world_m_s.dot(along(level, ray.arrival_dip_rad));
    }
    paths.push_back({ray, modem_.source_level_db - path_loss_db(modem_, water_, ray, depth_of(from), depth_of(to))});
  }
  const double closing_m_s = heard.closing_m_s;
  heard = reception(modem_, water_, paths);
  heard.closing_m_s = closing_m_s;
  return heard;
}

std::array<double, 2> LinkWater::overhear(const Transducer& from, const Transducer& to) const {
  const double length_m = (to.position_world_m - from.position_world_m).norm();
  if (from.position_world_m.z() > 0 || to.position_world_m.z() > 0) return {0, -300};
  const double middle_m = 0.5 * (depth_of(from) + depth_of(to));
  Eigenray straight;
  straight.length_m = length_m;
  return {length_m / water_.profile.at(middle_m),
          modem_.source_level_db - path_loss_db(modem_, water_, straight, middle_m, middle_m)};
}

}  // namespace uwsim
