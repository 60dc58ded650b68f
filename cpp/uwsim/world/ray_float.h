#pragma once

#include <Eigen/Core>

#include "uwsim/world/ray_geometry.h"
#include "uwsim/world/ray_packet.h"

namespace uwsim {

/// Embree's own answer to a packet, of rays that start `starts_m` along their way (0 when null); distances count from
/// the rays' origins.
void cast_float(RTCSceneTy* tree, const TileSurfaces& surfaces, const Eigen::Vector3d& anchor_world_m,
                const RayPacket& rays, const double* starts_m, HitPacket& hits, RayOrder order);
void occluded_float(RTCSceneTy* tree, const TileSurfaces& surfaces, const Eigen::Vector3d& anchor_world_m,
                    const RayPacket& rays, const double* starts_m, Blocked& blocked, RayOrder order);

}  // namespace uwsim
