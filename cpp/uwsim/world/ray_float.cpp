#include "uwsim/world/ray_float.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <limits>

namespace uwsim {
namespace {

RTCRay16 rays_of(const TileSurfaces& surfaces, const Eigen::Vector3d& anchor_world_m, const RayPacket& rays,
                 const double* starts_m) {
  RTCRay16 out;
  const Eigen::Vector3d shift = anchor_world_m - surfaces.middle_m();
  const Eigen::Vector3f near = shift.cast<float>();
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    out.org_x[k] = near.x() + rays.origin_x[k];
    out.org_y[k] = near.y() + rays.origin_y[k];
    out.org_z[k] = near.z() + rays.origin_z[k];
    out.dir_x[k] = rays.direction_x[k];
    out.dir_y[k] = rays.direction_y[k];
    out.dir_z[k] = rays.direction_z[k];
    out.tnear[k] = rays.near_m[k];
    out.tfar[k] = rays.far_m[k];
    out.time[k] = 0;
    out.mask[k] = ~0u;
    out.id[k] = static_cast<unsigned>(k);
    out.flags[k] = 0;
  }
  for (std::size_t k = 0; starts_m != nullptr && k < kPacketRays; ++k) {
    out.org_x[k] = static_cast<float>(shift.x() + rays.origin_x[k] + starts_m[k] * rays.direction_x[k]);
    out.org_y[k] = static_cast<float>(shift.y() + rays.origin_y[k] + starts_m[k] * rays.direction_y[k]);
    out.org_z[k] = static_cast<float>(shift.z() + rays.origin_z[k] + starts_m[k] * rays.direction_z[k]);
    out.tnear[k] = std::max(0.0f, static_cast<float>(rays.near_m[k] - starts_m[k]));
    out.tfar[k] = static_cast<float>(rays.far_m[k] - starts_m[k]);
  }
  return out;
}

}  // namespace

void cast_float(RTCSceneTy* tree, const TileSurfaces& surfaces, const Eigen::Vector3d& anchor_world_m,
                const RayPacket& rays, const double* starts_m, HitPacket& hits, RayOrder order) {
  RTCRayHit16 packet;
  packet.ray = rays_of(surfaces, anchor_world_m, rays, starts_m);
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    packet.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
    packet.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
  }
  intersect(tree, {&surfaces, nullptr, nullptr}, order, rays.active.data(), packet);
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    const std::uint32_t geometry = packet.hit.geomID[k];
    const bool met = geometry != RTC_INVALID_GEOMETRY_ID;
    const float start = starts_m != nullptr ? static_cast<float>(starts_m[k]) : 0.0f;
    hits.distance_m[k] = met ? start + packet.ray.tfar[k] : std::numeric_limits<float>::infinity();
    hits.u[k] = packet.hit.u[k];
    hits.v[k] = packet.hit.v[k];
    hits.normal_x[k] = packet.hit.Ng_x[k];
    hits.normal_y[k] = packet.hit.Ng_y[k];
    hits.normal_z[k] = packet.hit.Ng_z[k];
    hits.label[k] = met ? std::max<std::uint32_t>(geometry, kTerrain) : kNothing;
    hits.primitive[k] = met ? surfaces.world_number(geometry, packet.hit.primID[k]) : 0;
  }
}

void occluded_float(RTCSceneTy* tree, const TileSurfaces& surfaces, const Eigen::Vector3d& anchor_world_m,
                    const RayPacket& rays, const double* starts_m, Blocked& blocked, RayOrder order) {
  RTCRay16 packet = rays_of(surfaces, anchor_world_m, rays, starts_m);
  occluded(tree, {&surfaces, nullptr, nullptr}, order, rays.active.data(), packet);
  for (std::size_t k = 0; k < kPacketRays; ++k) {  // Embree marks what is blocked by tfar = -inf
    blocked[k] = packet.tfar[k] == -std::numeric_limits<float>::infinity() ? rays.active[k] : 0;
  }
}

}  // namespace uwsim
