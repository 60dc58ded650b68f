#pragma once

#include <Eigen/Core>

#include "uwsim/rays/embree_cast.h"
#include "uwsim/rays/ray_packet.h"

namespace uwsim {

// Pictures' rays: cast in float, and not solved again. ray_scene.h says by how much they may err.

/// The hits of a packet on round shapes, in double, and their numbers within the tile.
struct RoundAnswer {
  LazyExactRays rays;
  ExactHits hits;
  alignas(64) std::array<std::uint32_t, kPacketRays> primitive;

  RoundAnswer(const Eigen::Vector3d& anchor_world_m, const RayPacket& packet) : rays(anchor_world_m, packet) {}
};

/// Embree's own answer to a packet, of rays that start `starts_m` along their direction (0 when null); distances count
/// from the rays' origins. `round`, if not null, is filled where Embree asked a round shape; only for rays that start
/// at 0.
void cast_float(RTCSceneTy* tree, const TileSurfaces& surfaces, const Eigen::Vector3d& anchor_world_m,
                const RayPacket& rays, const double* starts_m, RoundAnswer* round, HitPacket& hits, RayOrder order);
void occluded_float(RTCSceneTy* tree, const TileSurfaces& surfaces, const Eigen::Vector3d& anchor_world_m,
                    const RayPacket& rays, const double* starts_m, Blocked& blocked, RayOrder order);

}  // namespace uwsim
