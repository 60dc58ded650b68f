#include "uwsim/rays/embree_float_cast.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "uwsim/rays/embree_terrain.h"

namespace uwsim {
namespace {

/// Each loop covers only one or two rows, so that compilers turn it into wide moves.
void fill(const TileSurfaces& surfaces, const Eigen::Vector3d& anchor_world_m, const RayPacket& rays,
          const double* starts_m, RTCRay16& out) {
  const Eigen::Vector3d shift = anchor_world_m - surfaces.middle_m();
  const Eigen::Vector3f near = shift.cast<float>();
  const auto shifted = [](const RayPacket::Lanes& from, float by, float* to) {
    for (std::size_t k = 0; k < kPacketRays; ++k) to[k] = by + from[k];
  };
  shifted(rays.origin_x, near.x(), out.org_x);
  shifted(rays.origin_y, near.y(), out.org_y);
  shifted(rays.origin_z, near.z(), out.org_z);
  std::ranges::copy(rays.direction_x, out.dir_x);
  std::ranges::copy(rays.direction_y, out.dir_y);
  std::ranges::copy(rays.direction_z, out.dir_z);
  std::ranges::copy(rays.near_m, out.tnear);
  std::ranges::copy(rays.far_m, out.tfar);
  std::ranges::fill(out.time, 0.0f);
  std::ranges::fill(out.mask, ~0u);
  std::ranges::fill(out.flags, 0u);
  for (std::size_t k = 0; k < kPacketRays; ++k) out.id[k] = static_cast<unsigned>(k);
  for (std::size_t k = 0; starts_m != nullptr && k < kPacketRays; ++k) {
    out.org_x[k] = static_cast<float>(shift.x() + rays.origin_x[k] + starts_m[k] * rays.direction_x[k]);
    out.org_y[k] = static_cast<float>(shift.y() + rays.origin_y[k] + starts_m[k] * rays.direction_y[k]);
    out.org_z[k] = static_cast<float>(shift.z() + rays.origin_z[k] + starts_m[k] * rays.direction_z[k]);
    out.tnear[k] = std::max(0.0f, static_cast<float>(rays.near_m[k] - starts_m[k]));
    out.tfar[k] = static_cast<float>(rays.far_m[k] - starts_m[k]);
  }
}

/// Moves hits on the raised terrain to the plane of the true triangle, unless the ray grazes it.
void lower_terrain(const RTCHit16& hit, double raise_m, RTCRay16& ray) {
  constexpr auto kLeastSine = static_cast<float>(kGrazingSine);
  const auto raise = static_cast<float>(raise_m);
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    if (!TileSurfaces::is_terrain(hit.geomID[k])) continue;  // normals of misses are uninitialised
    const float x = hit.Ng_x[k], y = hit.Ng_y[k], z = hit.Ng_z[k];
    const float length = std::sqrt(x * x + y * y + z * z);
    const float sinking = -(x * ray.dir_x[k] + y * ray.dir_y[k] + z * ray.dir_z[k]) / length;
    if (std::abs(sinking) > kLeastSine) ray.tfar[k] = std::max(0.0f, ray.tfar[k] + raise / sinking);
  }
}

/// Replaces quads, and the coordinates on them, by triangles and barycentric coordinates.
void number_triangles(RTCHit16& hit) {
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    if (!TileSurfaces::is_terrain(hit.geomID[k])) continue;
    const float u = hit.u[k], v = hit.v[k];
    hit.primID[k] = member_number(hit.geomID[k], hit.primID[k], u, v);
    const bool second = u + v > 1;  // the corners of the second triangle are the quad's second, third and fourth
    hit.u[k] = second ? u + v - 1 : u;
    hit.v[k] = second ? 1 - u : v;
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
  number_triangles(packet.hit);
  lower_terrain(packet.hit, surfaces.tolerances().raise_m, packet.ray);
  if (round != nullptr && round->rays.made()) std::ranges::copy(packet.hit.primID, round->primitive.begin());
  std::ranges::copy(packet.hit.u, hits.u.begin());
  std::ranges::copy(packet.hit.v, hits.v.begin());
  std::ranges::copy(packet.hit.Ng_x, hits.normal_x.begin());
  std::ranges::copy(packet.hit.Ng_y, hits.normal_y.begin());
  std::ranges::copy(packet.hit.Ng_z, hits.normal_z.begin());
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    const std::uint32_t geometry = packet.hit.geomID[k];
    const bool met = geometry != RTC_INVALID_GEOMETRY_ID;
    const float start = starts_m != nullptr ? static_cast<float>(starts_m[k]) : 0.0f;
    hits.distance_m[k] = met ? start + packet.ray.tfar[k] : std::numeric_limits<float>::infinity();
    hits.label[k] = met ? std::max<std::uint32_t>(geometry, kTerrain) : kNothing;
    hits.primitive[k] = met ? surfaces.world_number(geometry, packet.hit.primID[k]) : 0;
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
