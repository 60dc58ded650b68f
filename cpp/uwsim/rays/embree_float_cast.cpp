#include "uwsim/rays/embree_float_cast.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "uwsim/rays/embree.h"
#include "uwsim/rays/ray_kernels.h"

namespace uwsim {
namespace {

void fill(const TileSurfaces& surfaces, const Eigen::Vector3d& anchor_world_m, const RayPacket& rays,
          const double* starts_m, RTCRay16& out) {
  static_assert(offsetof(RayPacket, direction_z) == 5 * sizeof(RayPacket::Lanes));
  static_assert(offsetof(RTCRay16, tnear) == 3 * sizeof(RayPacket::Lanes) && sizeof(out) == 12 * sizeof(out.org_x));
  static const RayKernels& kernels = ray_kernels();
  const Eigen::Vector3d shift = anchor_world_m - surfaces.middle_m();
  const Eigen::Vector3f near = shift.cast<float>();
  kernels.fill_packet(rays.origin_x.data(), rays.near_m.data(), rays.far_m.data(), rays.active.data(), near.data(),
                      out.org_x);
  for (std::size_t k = 0; starts_m != nullptr && k < kPacketRays; ++k) {
    if (rays.active[k] == 0) continue;
    out.org_x[k] = static_cast<float>(shift.x() + rays.origin_x[k] + starts_m[k] * rays.direction_x[k]);
    out.org_y[k] = static_cast<float>(shift.y() + rays.origin_y[k] + starts_m[k] * rays.direction_y[k]);
    out.org_z[k] = static_cast<float>(shift.z() + rays.origin_z[k] + starts_m[k] * rays.direction_z[k]);
    out.tnear[k] = std::max(0.0f, static_cast<float>(rays.near_m[k] - starts_m[k]));
    out.tfar[k] = static_cast<float>(rays.far_m[k] - starts_m[k]);
  }
}

}  // namespace

void cast_float(RTCSceneTy* tree, const TileSurfaces& surfaces, const Eigen::Vector3d& anchor_world_m,
                const RayPacket& rays, const double* starts_m, RoundAnswer* round, HitPacket& hits, RayOrder order) {
  RTCRayHit16 packet;
  fill(surfaces, anchor_world_m, rays, starts_m, packet.ray);
  std::ranges::fill(packet.hit.geomID, RTC_INVALID_GEOMETRY_ID);
  std::ranges::fill(packet.hit.instID[0], RTC_INVALID_GEOMETRY_ID);
  CastDetail detail{.surfaces = &surfaces};
  if (round != nullptr) {
    detail.round_hits = &round->hits;
    detail.lazy = &round->rays;
  }
  intersect(tree, detail, order, rays.active.data(), packet);
  if (round != nullptr && round->rays.made()) std::ranges::copy(packet.hit.primID, round->primitive.begin());
  static const RayKernels& kernels = ray_kernels();
  // Completed before it is copied: the kernel would have to wait for rows that were copied in narrower moves.
  const bool others = kernels.complete_floats(
      {packet.hit.geomID, packet.hit.primID, hits.label.data(), packet.hit.u, packet.hit.v, packet.ray.tfar,
       packet.hit.Ng_x, packet.hit.Ng_y, packet.hit.Ng_z, packet.ray.dir_x, packet.ray.dir_y, packet.ray.dir_z},
      TileSurfaces::kOpenTerrain, static_cast<float>(surfaces.tolerances().raise_m));
  std::ranges::copy(packet.hit.u, hits.u.begin());
  std::ranges::copy(packet.hit.v, hits.v.begin());
  std::ranges::copy(packet.hit.Ng_x, hits.normal_x.begin());
  std::ranges::copy(packet.hit.Ng_y, hits.normal_y.begin());
  std::ranges::copy(packet.hit.Ng_z, hits.normal_z.begin());
  std::ranges::copy(packet.ray.tfar, hits.distance_m.begin());
  std::ranges::copy(packet.hit.primID, hits.primitive.begin());
  for (std::size_t k = 0; starts_m != nullptr && k < kPacketRays; ++k) {
    hits.distance_m[k] = static_cast<float>(starts_m[k]) + hits.distance_m[k];
  }
  if (!others && surfaces.has_whole_terrain()) return;
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    const std::uint32_t geometry = packet.hit.geomID[k];
    if (geometry != kNoGeometry) hits.primitive[k] = surfaces.world_number(geometry, hits.primitive[k]);
  }
}

void occluded_float(RTCSceneTy* tree, const TileSurfaces& surfaces, const Eigen::Vector3d& anchor_world_m,
                    const RayPacket& rays, const double* starts_m, Blocked& blocked, RayOrder order) {
  RTCRay16 packet;
  fill(surfaces, anchor_world_m, rays, starts_m, packet);
  occluded(tree, {.surfaces = &surfaces}, order, rays.active.data(), packet);
  for (std::size_t k = 0; k < kPacketRays; ++k) {  // Embree marks blocked rays with tfar = -inf
    blocked[k] = packet.tfar[k] == -std::numeric_limits<float>::infinity() ? rays.active[k] : 0;
  }
}

}  // namespace uwsim
