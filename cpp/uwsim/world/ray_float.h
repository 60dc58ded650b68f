#pragma once

#include <Eigen/Core>

#include "uwsim/world/ray_geometry.h"
#include "uwsim/world/ray_packet.h"

namespace uwsim {

/// Round hits of a packet, as its rays in double have them, and their numbers within the tile.
struct RoundAnswer {
  LateRays rays;
  ExactHits hits;
  alignas(64) std::array<std::uint32_t, kPacketRays> primitive;

  RoundAnswer(const Eigen::Vector3d& anchor_world_m, const RayPacket& of) : rays(anchor_world_m, of) {}
};

/// Embree's own answer to a packet, of rays that start `starts_m` along their way (0 when null); distances count from
/// the rays' origins. `round`, if not null, is filled where a round solid was asked; for rays that start at 0 only.
void cast_float(RTCSceneTy* tree, const TileSurfaces& surfaces, const Eigen::Vector3d& anchor_world_m,
                const RayPacket& rays, const double* starts_m, RoundAnswer* round, HitPacket& hits, RayOrder order);
void occluded_float(RTCSceneTy* tree, const TileSurfaces& surfaces, const Eigen::Vector3d& anchor_world_m,
                    const RayPacket& rays, const double* starts_m, Blocked& blocked, RayOrder order);

}  // namespace uwsim
