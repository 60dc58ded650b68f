#include "uwsim/sim/link.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "uwsim/acoustics/sound_path.h"
#include "uwsim/core/check.h"
#include "uwsim/sonar/water_sound.h"

namespace uwsim {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kDeepest_m = 12000;
constexpr int kChords = 8;             // of a bent ray, to see what stands in its way
constexpr double kOffTheBed = 0.05;    // of the water's depth: how far from the flat bottom a bouncing ray is looked at
constexpr double kBesideHit_m = 0.01;  // to go on behind a solid
constexpr int kSolidsPassed = 8;

double depth_of(const Transducer& transducer) { return std::max(0.0, -transducer.position_world_m.z()); }

Eigen::Vector3d along(const Eigen::Vector3d& level, double dip_rad) {
  return std::cos(dip_rad) * level - std::sin(dip_rad) * Eigen::Vector3d::UnitZ();
}

/// Whether terrain lies between two points.
bool blocked(const RayScene& scene, Eigen::Vector3d from, const Eigen::Vector3d& to) {
  for (int passed = 0; passed < kSolidsPassed; ++passed) {
    const Eigen::Vector3d line = to - from;
    const double length = line.norm();
    if (!(length > 2 * kBesideHit_m)) return false;
    const RayHit hit = scene.cast({from, line / length}, length);
    if (!(hit.distance_m < length)) return false;
    if (hit.label == kTerrain) return true;
    from += (hit.distance_m + kBesideHit_m) / length * line;
  }
  return false;
}

/// The depth of the first surface under a point; infinite where there is none.
double bed_under(const RayScene& scene, const Eigen::Vector3d& point_world_m) {
  const Eigen::Vector3d top(point_world_m.x(), point_world_m.y(), 0);
  return scene.cast({top, -Eigen::Vector3d::UnitZ()}, kDeepest_m).distance_m;
}

/// The corners of a ray, or points on it where it bends.
std::vector<Eigen::Vector3d> trace(const SoundSpeedProfile& profile, const Eigenray& ray, const Transducer& from,
                                   const Transducer& to, const Eigen::Vector3d& level, double bottom_m) {
  std::vector<Eigen::Vector3d> points = {from.position_world_m};
  const double start_m = depth_of(from);
  const auto add = [&](double across_m, double depth_m) {
    points.push_back(from.position_world_m + across_m * level + (start_m - depth_m) * Eigen::Vector3d::UnitZ());
  };
  if (ray.surface_bounces + ray.bottom_bounces == 0) {
    for (int k = 1; k < kChords && profile.steepest_1_s() > 0; ++k) {
      const SoundState at = travel(profile, start_m, ray.launch_dip_rad, ray.time_s * k / kChords);
      add(at.across_m, at.depth_m);
    }
  } else {
    double across_m = 0;
    bool at_surface = ray.launch_dip_rad < 0;
    for (int k = 0; k + 1 < ray.legs; ++k, at_surface = !at_surface) {
      across_m += ray.across_m[static_cast<std::size_t>(k)];
      add(across_m, at_surface ? 0 : (1 - kOffTheBed) * bottom_m);
    }
  }
  points.push_back(to.position_world_m);
  return points;
}

bool visible(const RayScene& scene, const std::vector<Eigen::Vector3d>& points) {
  for (std::size_t k = 1; k < points.size(); ++k) {
    if (blocked(scene, points[k - 1], points[k])) return false;
  }
  return true;
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
  if (from.position_world_m.z() > 0 || to.position_world_m.z() > 0) return {};  // a transducer is in the air
  const double across_m = std::hypot(line.x(), line.y());
  const Eigen::Vector3d level =
      across_m > 0 ? Eigen::Vector3d(line.x() / across_m, line.y() / across_m, 0) : Eigen::Vector3d(1, 0, 0);
  const double deepest = std::max(depth_of(from), depth_of(to));
  double bottom_m = bed_under(scene, 0.5 * (from.position_world_m + to.position_world_m));
  if (bottom_m <= deepest) bottom_m = kInfinity;  // the bed half-way stands above the ends: nothing bounces off it
  std::vector<HeardPath> paths;
  double first_s = kInfinity;
  for (const Eigenray& ray : eigenrays(water_.profile, {depth_of(from), depth_of(to), across_m, bottom_m})) {
    if (!visible(scene, trace(water_.profile, ray, from, to, level, bottom_m))) continue;
    paths.push_back({ray, modem_.source_level_db - path_loss_db(modem_, water_, ray, depth_of(from), depth_of(to))});
    if (ray.time_s >= first_s) continue;
    first_s = ray.time_s;
    heard.closing_m_s = from.velocity_world_m_s.dot(along(level, ray.launch_dip_rad)) -
                        to.velocity_world_m_s.dot(along(level, ray.arrival_dip_rad));
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
