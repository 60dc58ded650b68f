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
static_assert(kBentTogether == kPacketRays);

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
        from_{depth_m_, profile.at(depth_m_), static_cast<std::int32_t>(profile.layer_ahead(depth_m_, false)),
              static_cast<std::int32_t>(profile.layer_ahead(depth_m_, true))} {
    packet_.near_m.fill(0);
  }

  /// Returns the number of chords cast.
  std::size_t cast(std::span<const Eigen::Vector3d> directions_world, std::span<SoundHit> hits) {
    DirectionRows directions;
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      const Eigen::Vector3d& direction = directions_world[std::min(k, hits.size() - 1)];
      directions.x[k] = direction.x(), directions.y[k] = direction.y(), directions.z[k] = direction.z();
    }
    kernels_.start(profile_.layers().data(), from_, directions, rays_);
    std::fill(rays_.done + hits.size(), rays_.done + kPacketRays, -1);
    for (SoundHit& hit : hits) hit.label = kNothing;
    std::size_t count = 0;
    for (int chord = 0; chord < kChordsMax && next_chords(); ++chord) {
      count += static_cast<std::size_t>(-std::accumulate(packet_.active.begin(), packet_.active.end(), 0));
      scene_.cast(origin_world_m_, packet_, found_, RayOrder::kCoherent);
      place_hits(hits);
    }
    for (std::size_t k = 0; k < hits.size(); ++k) {
      // A chord's overlap may have hit something above the water.
      if (hits[k].label != kNothing && hits[k].point_world_m.z() <= 0) continue;
      hits[k] = {kInfinity, kInfinity, origin_world_m_, Eigen::Vector3f::Zero(), directions_world[k], kNothing};
    }
    return count;
  }

 private:
  /// Returns whether any ray goes on.
  bool next_chords() {
    kernels_.next_chords(
        profile_.layers().data(), depth_m_, time_max_s_, rays_,
        {packet_.origin_x.data(), packet_.origin_y.data(), packet_.origin_z.data(), packet_.direction_x.data(),
         packet_.direction_y.data(), packet_.direction_z.data(), packet_.far_m.data(), packet_.active.data()});
    return std::ranges::any_of(packet_.active, [](std::int32_t active) { return active != 0; });
  }

  /// Records which chords hit something; those rays are done.
  void place_hits(std::span<SoundHit> hits) {
    std::array<std::int32_t, kPacketRays> met;
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      met[k] = packet_.active[k] != 0 && std::isfinite(found_.distance_m[k]) ? -1 : 0;
      rays_.done[k] |= met[k] | rays_.surfaces[k];
    }
    PathHits placed;
    kernels_.place_hits(
        rays_, depth_m_,
        {found_.distance_m.data(), found_.normal_x.data(), found_.normal_y.data(), found_.normal_z.data(), met.data()},
        placed);
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      if (met[k] == 0) continue;
      hits[k] = {placed.length_m[k],
                 placed.time_s[k],
                 origin_world_m_ + Eigen::Vector3d(placed.x[k], placed.y[k], placed.z[k]),
                 {found_.normal_x[k], found_.normal_y[k], found_.normal_z[k]},
                 {placed.arrival_x[k], placed.arrival_y[k], placed.arrival_z[k]},
                 static_cast<Label>(found_.label[k])};
    }
  }

  const RayScene& scene_;
  const SoundSpeedProfile& profile_;
  const Eigen::Vector3d& origin_world_m_;
  double time_max_s_;
  double depth_m_;  // of the origin
  BentStart from_;
  const BentKernels& kernels_ = bent_kernels();
  BentRays rays_{};
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
