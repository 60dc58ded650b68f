#include "uwsim/sonar/bent_cast.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "uwsim/core/check.h"
#include "uwsim/core/infinity.h"
#include "uwsim/sonar/bent_kernels.h"

namespace uwsim {
namespace {

constexpr int kChordsMax = 100'000;
constexpr std::size_t kHalves = kPacketRays / kBentTogether;

/// A packet of rays that are traced and cast together.
class BentPacket {
 public:
  BentPacket(const RayScene& scene, const SoundSpeedProfile& profile, const Eigen::Vector3d& origin_world_m,
             double time_max_s)
      : scene_(scene),
        profile_(profile),
        origin_world_m_(origin_world_m),
        time_max_s_(time_max_s),
        depth_m_(-origin_world_m.z()),
        speed_m_s_(profile.at(depth_m_)),
        layer_below_(profile.layer_ahead(depth_m_, false)),
        layer_above_(profile.layer_ahead(depth_m_, true)) {
    packet_.near_m.fill(0);
  }

  /// Returns the number of chords cast.
  std::size_t cast(std::span<const Eigen::Vector3d> directions_world, std::span<SoundHit> hits) {
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      const std::size_t ray = std::min(k, hits.size() - 1);
      start(k, directions_world[ray], k < hits.size());
      hits[ray] = {kInfinity, kInfinity, origin_world_m_, Eigen::Vector3f::Zero(), directions_world[ray], kNothing};
    }
    std::size_t count = 0;
    for (int chord = 0; chord < kChordsMax && next_chords(); ++chord) {
      count += static_cast<std::size_t>(-std::accumulate(packet_.active.begin(), packet_.active.end(), 0));
      scene_.cast(origin_world_m_, packet_, found_, RayOrder::kCoherent);
      place_hits(hits);
    }
    for (SoundHit& hit : hits) {
      if (hit.label == kNothing || hit.point_world_m.z() <= 0) continue;
      hit.length_m = hit.time_s = kInfinity;  // the overlap hit something above the water
      hit.label = kNothing;
    }
    return count;
  }

 private:
  void start(std::size_t ray, const Eigen::Vector3d& direction_world, bool exists) {
    BentRays& rays = halves_[ray / kBentTogether];
    ArcRows& arc = rays.end;
    const std::size_t k = ray % kBentTogether;
    const Eigen::Vector3d& d = direction_world;
    const double across = std::sqrt(d.x() * d.x() + d.y() * d.y()), dip_rad = std::atan2(-d.z(), across);
    rays.level_x[k] = across > 0 ? d.x() / across : 1;
    rays.level_y[k] = across > 0 ? d.y() / across : 0;
    // A ray from the surface does not head up, and none starts in air.
    rays.done[k] = !exists || depth_m_ < 0 || (depth_m_ <= 0 && dip_rad <= 0) ? -1 : 0;
    const std::size_t number = dip_rad < 0 ? layer_above_ : layer_below_;
    const SoundLayer& layer = profile_.layers()[number];
    rays.layer[k] = static_cast<std::int32_t>(number);
    arc.across_m[k] = arc.time_s[k] = arc.length_m[k] = 0;
    arc.depth_m[k] = depth_m_, arc.dip_rad[k] = dip_rad;
    arc.cosine[k] = across, arc.sine[k] = -d.z();
    arc.snell_s_m[k] = across / speed_m_s_;
    arc.curvature_1_m[k] = -arc.snell_s_m[k] * layer.gradient_1_s;
    arc.top_m[k] = layer.top_m, arc.bottom_m[k] = layer.bottom_m, arc.reference_m[k] = layer.reference_m;
    arc.speed_m_s[k] = layer.speed_m_s, arc.gradient_1_s[k] = layer.gradient_1_s;
  }

  /// Returns whether any ray goes on.
  bool next_chords() {
    const SoundLayer* layers = profile_.layers().data();
    for (std::size_t half = 0; half < kHalves; ++half) {
      const std::size_t at = half * kBentTogether;
      kernels_.next_chords(
          layers, depth_m_, time_max_s_, halves_[half],
          {&packet_.origin_x[at], &packet_.origin_y[at], &packet_.origin_z[at], &packet_.direction_x[at],
           &packet_.direction_y[at], &packet_.direction_z[at], &packet_.far_m[at], &packet_.active[at]});
    }
    return std::ranges::any_of(packet_.active, [](std::int32_t active) { return active != 0; });
  }

  /// Records which chords hit something; those rays are done.
  void place_hits(std::span<SoundHit> hits) {
    for (std::size_t half = 0; half < kHalves; ++half) {
      const std::size_t at = half * kBentTogether;
      BentRays& rays = halves_[half];
      std::array<std::int32_t, kBentTogether> met;
      std::int32_t any = 0;
      for (std::size_t k = 0; k < kBentTogether; ++k) {
        met[k] = packet_.active[at + k] != 0 && std::isfinite(found_.distance_m[at + k]) ? -1 : 0;
        rays.done[k] |= met[k] | rays.surfaces[k];
        any |= met[k];
      }
      if (any == 0) continue;
      PathHits placed;
      kernels_.place_hits(
          rays, depth_m_,
          {&found_.distance_m[at], &found_.normal_x[at], &found_.normal_y[at], &found_.normal_z[at], met.data()},
          placed);
      for (std::size_t k = 0; k < kBentTogether; ++k) {
        if (met[k] == 0) continue;
        hits[at + k] = {placed.length_m[k],
                        placed.time_s[k],
                        origin_world_m_ + Eigen::Vector3d(placed.x[k], placed.y[k], placed.z[k]),
                        {found_.normal_x[at + k], found_.normal_y[at + k], found_.normal_z[at + k]},
                        {placed.arrival_x[k], placed.arrival_y[k], placed.arrival_z[k]},
                        static_cast<Label>(found_.label[at + k])};
      }
    }
  }

  const RayScene& scene_;
  const SoundSpeedProfile& profile_;
  const Eigen::Vector3d& origin_world_m_;
  double time_max_s_;
  double depth_m_, speed_m_s_;  // at the origin
  std::size_t layer_below_, layer_above_;
  const BentKernels& kernels_ = bent_kernels();
  std::array<BentRays, kHalves> halves_{};
  RayPacket packet_{};
  HitPacket found_;
};

}  // namespace

std::size_t cast_bent(const RayScene& scene, const SoundSpeedProfile& profile, const Eigen::Vector3d& origin_world_m,
                      std::span<const Eigen::Vector3d> directions_world, double time_max_s, std::span<SoundHit> hits) {
  require(hits.size() == directions_world.size(), "hits.size", hits.size(), "must equal the number of directions");
  BentPacket packet(scene, profile, origin_world_m, time_max_s);
  std::size_t chords = 0;
  for (std::size_t first = 0; first < hits.size(); first += kPacketRays) {
    const std::size_t count = std::min(kPacketRays, hits.size() - first);
    chords += packet.cast(directions_world.subspan(first, count), hits.subspan(first, count));
  }
  return chords;
}

}  // namespace uwsim
