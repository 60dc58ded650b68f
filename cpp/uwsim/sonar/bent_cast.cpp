#include "uwsim/sonar/bent_cast.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "uwsim/acoustics/sound_path.h"
#include "uwsim/core/check.h"
#include "uwsim/core/infinity.h"

namespace uwsim {
namespace {

// The largest distance between a chord and its path: a share of the distance travelled to the chord's end, or at least
// a millimetre.
constexpr double kSagShare = 1e-3, kLeastSag_m = 1e-3;
// Chords are cast slightly beyond their ends, so that no surface is missed between two of them.
constexpr double kOverlap_m = 1e-3;
constexpr int kChordsMax = 100'000;
constexpr std::size_t kPiecesMax = 6;  // of a chord
constexpr double kFastest_m_s = 1800;
constexpr double kShortest_m = 1e-9;
// The cosine of the incidence below which the tangent plane does not place a hit along the path.
constexpr double kGrazing = 0.1;

/// A ray being traced. Its path lies in the vertical plane through `level_world`.
struct BentRay {
  Eigen::Vector3d level_world;
  // The layers that the present chord passes: piece k leads from the start of pieces[k] to that of pieces[k + 1], or to
  // the end of the chord.
  std::array<SoundPath, kPiecesMax> pieces;
  std::size_t count = 0;
  SoundPath end;
  bool surfaces = false;  // whether the chord ends at the water's surface
  double chord_m = 0;
  int chords = 0;
  bool done = false;

  explicit BentRay(const SoundPath& start, const Eigen::Vector3d& along_level_world)
      : level_world(along_level_world), pieces(repeated(start)), end(start) {}

  /// Position relative to the start of the ray.
  Eigen::Vector3d at(const SoundState& state, double start_depth_m) const {
    return {state.across_m * level_world.x(), state.across_m * level_world.y(), start_depth_m - state.depth_m};
  }
  const SoundState& start_of(std::size_t piece) const { return piece < count ? pieces[piece].state() : end.state(); }

 private:
  static std::array<SoundPath, kPiecesMax> repeated(const SoundPath& path) {
    return [&]<std::size_t... k>(std::index_sequence<k...>) {
      return std::array<SoundPath, kPiecesMax>{((void)k, path)...};
    }
    (std::make_index_sequence<kPiecesMax>());
  }
};

/// The length of the first arc of a chord, of curvature k: its sag k L^2 / 8 equals that allowed at its end.
double first_length_m(double curvature_1_m, double gone_m) {
  if (!(curvature_1_m > 0)) return kInfinity;
  const double share_m = 4 * kSagShare / curvature_1_m;
  return std::max(std::sqrt(8 * kLeastSag_m / curvature_1_m), share_m + std::sqrt(share_m * (share_m + 2 * gone_m)));
}

/// How much longer a chord may become by an arc of curvature k, if it has a length of `chord_m` and turned by
/// `turn_rad` so far: a path of length L that turns by D in total departs from its chord by less than L D / 4.
double further_length_m(double curvature_1_m, double chord_m, double turn_rad, double sag_m) {
  const double left = 4 * sag_m - chord_m * turn_rad, slope = turn_rad + curvature_1_m * chord_m;
  if (!(left > 0)) return 0;
  return 2 * left / (slope + std::sqrt(slope * slope + 4 * curvature_1_m * left));
}

/// Sets the next chord: it ends where its distance from the path reaches the maximum, at the maximum time, or at the
/// surface, whichever comes first. Returns whether there is one.
bool next_chord(BentRay& ray, double time_max_s) {
  const double gone_m = ray.end.state().length_m;
  double turn_rad = 0;
  for (ray.count = 0; ray.count < kPiecesMax;) {
    const double curvature = std::abs(ray.end.curvature_1_m()), chord_m = ray.end.state().length_m - gone_m;
    const double sag_m = std::max(kLeastSag_m, kSagShare * ray.end.state().length_m);
    const double most_m =
        ray.count == 0 ? first_length_m(curvature, gone_m) : further_length_m(curvature, chord_m, turn_rad, sag_m);
    if (!(most_m > 0.1 * chord_m)) break;  // not worth another piece
    const double left_s = time_max_s - ray.end.state().time_s;
    SoundPath::Step step = ray.end.step(std::min(most_m, kFastest_m_s * left_s));
    if (step.end.time_s > time_max_s) step = {ray.end.ahead(ray.end.length_after(left_s)), false};
    const double length_m = step.end.length_m - ray.end.state().length_m;
    if (!(length_m > kShortest_m)) break;
    ray.pieces[ray.count++] = ray.end;
    turn_rad += curvature * length_m;
    ray.surfaces = ray.end.advance(step);
    if (ray.surfaces || !step.leaves) break;
  }
  return ray.count > 0;
}

void set_chord(RayPacket& packet, std::size_t lane, BentRay& ray, double start_depth_m) {
  const Eigen::Vector3d from = ray.at(ray.start_of(0), start_depth_m);
  const Eigen::Vector3d along = ray.at(ray.end.state(), start_depth_m) - from;
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

/// Moves the hit from the chord to the path, along the surface's tangent plane; where the ray grazes it, across the
/// chord.
void record_hit(const BentRay& ray, double distance_m, const Eigen::Vector3d& origin_world_m, SoundHit& hit) {
  const double start_depth_m = -origin_world_m.z();
  const Eigen::Vector3d from = ray.at(ray.start_of(0), start_depth_m);
  const Eigen::Vector3d along = (ray.at(ray.end.state(), start_depth_m) - from) / ray.chord_m;
  const auto place_m = [&](std::size_t piece) {
    return (ray.at(ray.start_of(piece), start_depth_m) - from).dot(along);
  };
  std::size_t piece = 0;
  while (piece + 1 < ray.count && place_m(piece + 1) <= distance_m) ++piece;
  const double begin_m = place_m(piece), end_m = place_m(piece + 1);
  const SoundPath& path = ray.pieces[piece];
  const double share = std::clamp((distance_m - begin_m) / (end_m - begin_m), 0.0, 1.0);
  double ahead_m = share * (ray.start_of(piece + 1).length_m - path.state().length_m);
  const Eigen::Vector3d met = from + distance_m * along, normal = hit.normal_world.cast<double>().normalized();
  const Eigen::Vector3d plane = std::abs(normal.dot(along)) > kGrazing ? normal : along;
  const auto onward = [&](const SoundState& there) {
    const SoundPath::Direction towards = path.direction_at(there);
    return Eigen::Vector3d(towards.cosine * ray.level_world - towards.sine * Eigen::Vector3d::UnitZ());
  };
  // One step of Newton's method: over the distance that is left, the path bends by less than half a millimetre.
  const SoundState near = path.ahead(ahead_m);
  ahead_m += plane.dot(met - ray.at(near, start_depth_m)) / plane.dot(onward(near));
  const SoundState arrival = path.ahead(ahead_m);
  hit.length_m = arrival.length_m;
  hit.time_s = arrival.time_s;
  hit.point_world_m = origin_world_m + ray.at(arrival, start_depth_m);
  hit.arrival_world = onward(arrival);
}

std::size_t cast_packet(const RayScene& scene, const SoundSpeedProfile& profile, const Eigen::Vector3d& origin_world_m,
                        std::span<const Eigen::Vector3d> directions_world, double time_max_s,
                        std::span<SoundHit> hits) {
  std::array<std::optional<BentRay>, kPacketRays> rays;
  for (std::size_t k = 0; k < hits.size(); ++k) {
    const Eigen::Vector3d& direction = directions_world[k];
    const double across = std::sqrt(direction.x() * direction.x() + direction.y() * direction.y());
    const double dip = std::atan2(-direction.z(), across);
    const Eigen::Vector3d level_world =
        across > 0 ? Eigen::Vector3d(direction.x() / across, direction.y() / across, 0) : Eigen::Vector3d::UnitX();
    rays[k].emplace(SoundPath(profile, -origin_world_m.z(), dip, across, -direction.z()), level_world);
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
      if (++ray.chords > kChordsMax || !next_chord(ray, time_max_s)) {
        ray.done = true;
        continue;
      }
      set_chord(packet, k, ray, -origin_world_m.z());
      going = true;
      ++cast;
    }
    if (!going) break;
    scene.cast(origin_world_m, packet, found, RayOrder::kCoherent);
    for (std::size_t k = 0; k < hits.size(); ++k) {
      if (packet.active[k] == 0) continue;
      BentRay& ray = *rays[k];
      ray.done = ray.surfaces;
      if (!std::isfinite(found.distance_m[k])) continue;
      hits[k].normal_world = {found.normal_x[k], found.normal_y[k], found.normal_z[k]};
      hits[k].label = static_cast<Label>(found.label[k]);
      record_hit(ray, found.distance_m[k], origin_world_m, hits[k]);
      ray.done = true;
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
