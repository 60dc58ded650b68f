#include "uwsim/sonar/bent_cast.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "uwsim/acoustics/sound_path.h"
#include "uwsim/core/check.h"
#include "uwsim/core/infinity.h"

namespace uwsim {
namespace {

constexpr double kSag_m = 0.9e-3;  // largest distance between a chord and its arc
// Chords are cast slightly beyond their ends, so that no surface is missed between two of them.
constexpr double kOverlap_m = 1e-3;
constexpr int kChordsMax = 100'000;

Eigen::Vector3d level(const Eigen::Vector3d& direction_world) {
  const Eigen::Vector3d flat(direction_world.x(), direction_world.y(), 0);
  const double length = flat.norm();
  return length > 0 ? Eigen::Vector3d(flat / length) : Eigen::Vector3d::UnitX();
}

/// A ray being traced. Its path lies in the vertical plane through `level_world`.
struct BentRay {
  Eigen::Vector3d level_world;
  SoundPath path;
  SoundPath::Step next;  // the step whose chord is to be cast
  double chord_m = 0;
  int chords = 0;
  bool done = false;

  /// Position relative to the start of the ray.
  Eigen::Vector3d at(const SoundState& state, double start_depth_m) const {
    return {state.across_m * level_world.x(), state.across_m * level_world.y(), start_depth_m - state.depth_m};
  }
};

/// The next chord: it ends at the layer's boundary, at the largest sag, or at the maximum time, whichever comes first.
SoundPath::Step next_chord(const SoundPath& path, double time_max_s) {
  const double curvature = std::abs(path.curvature_1_m());
  const double left_s = time_max_s - path.state().time_s;
  constexpr double kFastest_m_s = 1800;
  const double straight_m = curvature > 0 ? std::sqrt(8 * kSag_m / curvature) : kInfinity;
  const SoundPath::Step step = path.step(std::min(straight_m, kFastest_m_s * left_s));
  return step.end.time_s <= time_max_s ? step : SoundPath::Step{path.ahead(path.length_after(left_s)), false};
}

void set_chord(RayPacket& packet, std::size_t lane, BentRay& ray, double start_depth_m) {
  const Eigen::Vector3d from = ray.at(ray.path.state(), start_depth_m);
  const Eigen::Vector3d along = ray.at(ray.next.end, start_depth_m) - from;
  ray.chord_m = along.norm();
  const Eigen::Vector3f start = from.cast<float>(), direction = (along / ray.chord_m).cast<float>();
  packet.origin_x[lane] = start.x();
  packet.origin_y[lane] = start.y();
  packet.origin_z[lane] = start.z();
  packet.direction_x[lane] = direction.x();
  packet.direction_y[lane] = direction.y();
  packet.direction_z[lane] = direction.z();
  packet.near_m[lane] = 0;
  packet.far_m[lane] = static_cast<float>(ray.chord_m + kOverlap_m);
  packet.active[lane] = -1;
}

void record_hit(const BentRay& ray, double distance_m, const Eigen::Vector3d& origin_world_m, SoundHit& hit) {
  const SoundState& start = ray.path.state();
  const double share = distance_m / ray.chord_m;
  const SoundState arrival = ray.path.ahead((ray.next.end.length_m - start.length_m) * std::min(1.0, share));
  const Eigen::Vector3d from = ray.at(start, -origin_world_m.z()), to = ray.at(ray.next.end, -origin_world_m.z());
  hit.length_m = arrival.length_m;
  hit.time_s = arrival.time_s;
  hit.point_world_m = origin_world_m + from + (to - from) * share;
  hit.arrival_world =
      std::cos(arrival.dip_rad) * ray.level_world - std::sin(arrival.dip_rad) * Eigen::Vector3d::UnitZ();
}

std::size_t cast_packet(const RayScene& scene, const SoundSpeedProfile& profile, const Eigen::Vector3d& origin_world_m,
                        std::span<const Eigen::Vector3d> directions_world, double time_max_s,
                        std::span<SoundHit> hits) {
  std::array<std::optional<BentRay>, kPacketRays> rays;
  for (std::size_t k = 0; k < hits.size(); ++k) {
    const Eigen::Vector3d& direction = directions_world[k];
    const double dip = std::atan2(-direction.z(), std::hypot(direction.x(), direction.y()));
    rays[k] = BentRay{level(direction), SoundPath(profile, -origin_world_m.z(), dip), {}};
    rays[k]->done = origin_world_m.z() >= 0 && dip <= 0;  // the ray starts at the surface and does not head down
    hits[k] = {kInfinity, kInfinity, origin_world_m, Eigen::Vector3f::Zero(), direction, kNothing};
  }
  RayPacket packet{};
  HitPacket found;
  std::size_t cast = 0;
  for (bool going = origin_world_m.z() <= 0; going;) {
    going = false;
    packet.active.fill(0);
    for (std::size_t k = 0; k < hits.size(); ++k) {
      BentRay& ray = *rays[k];
      if (ray.done) continue;
      ray.next = next_chord(ray.path, time_max_s);
      if (!(ray.next.end.length_m - ray.path.state().length_m > 1e-9) || ++ray.chords > kChordsMax) {
        ray.done = true;
        continue;
      }
      set_chord(packet, k, ray, -origin_world_m.z());
      going = true;
      ++cast;
    }
    if (!going) break;
    scene.cast(origin_world_m, packet, found);
    for (std::size_t k = 0; k < hits.size(); ++k) {
      if (packet.active[k] == 0) continue;
      BentRay& ray = *rays[k];
      if (std::isfinite(found.distance_m[k])) {
        record_hit(ray, found.distance_m[k], origin_world_m, hits[k]);
        hits[k].normal_world = {found.normal_x[k], found.normal_y[k], found.normal_z[k]};
        hits[k].label = static_cast<Label>(found.label[k]);
        ray.done = true;
      } else {
        ray.done = ray.path.advance(ray.next);
      }
    }
  }
  for (SoundHit& hit : hits) {
    if (hit.label == kNothing || hit.point_world_m.z() <= 0) continue;
    hit.length_m = hit.time_s = kInfinity;  // the overlap hit something above the water
    hit.label = kNothing;
  }
  return cast;
}

}  // namespace

std::size_t cast_bent(const RayScene& scene, const SoundSpeedProfile& profile, const Eigen::Vector3d& origin_world_m,
                      std::span<const Eigen::Vector3d> directions_world, double time_max_s, std::span<SoundHit> hits) {
  require(hits.size() == directions_world.size(), "hits.size", hits.size(), "must equal the number of directions");
  std::size_t chords = 0;
  for (std::size_t first = 0; first < hits.size(); first += kPacketRays) {
    const std::size_t count = std::min(kPacketRays, hits.size() - first);
    chords += cast_packet(scene, profile, origin_world_m, directions_world.subspan(first, count), time_max_s,
                          hits.subspan(first, count));
  }
  return chords;
}

}  // namespace uwsim
