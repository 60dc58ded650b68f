#pragma once

#include <Eigen/Core>

#include "uwsim/rays/embree_cast.h"
#include "uwsim/rays/ray_packet.h"

namespace uwsim {

// Rays for pictures, which are cast in float and not recomputed in double. ray_scene.h states their error bounds.

/// The hits of a packet on round shapes, in double, with their numbers within the tile.
struct RoundAnswer {
  LazyExactRays rays;
  ExactHits hits;
  alignas(64) std::array<std::uint32_t, kPacketRays> primitive;

  RoundAnswer(const Eigen::Vector3d& anchor_world_m, const RayPacket& packet) : rays(anchor_world_m, packet) {}
};

/// Returns Embree's own answer to a packet of rays that start `starts_m` along their direction (0 if null); distances
/// are measured from the rays' origins. If `round` is not null, it receives the hits on the round shapes that Embree
/// queried; this is only supported for rays that start at 0.
void cast_float(RTCSceneTy* tree, const TileSurfaces& surfaces, const Eigen::Vector3d& anchor_world_m,
                const RayPacket& rays, const double* starts_m, RoundAnswer* round, HitPacket& hits, RayOrder order);
void occluded_float(RTCSceneTy* tree, const TileSurfaces& surfaces, const Eigen::Vector3d& anchor_world_m,
                    const RayPacket& rays, const double* starts_m, Blocked& blocked, RayOrder order);

}  // namespace uwsim
