#include "uwsim/camera/tracer.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "uwsim/camera/block_mask.h"
#include "uwsim/core/check.h"
#include "uwsim/rays/tolerances.h"

namespace uwsim {
namespace {

using camera::Block;
using camera::BlockMask;

constexpr float kFarthest_m = 1e5f;
constexpr float kShadowStart_m = 1e-3f;  // prevents a shadow ray from hitting its own surface
constexpr double kRefineTo_m = 1e5;

/// Copies sixteen 32-bit values as one wide move.
template <typename To, typename From>
void copy(To& to, const From& from) {
  static_assert(sizeof(To) == 64 && sizeof(From) == 64);
  std::memcpy(&to, &from, 64);
}

RayPacket packet_of(const camera::BlockVectors& origin, const camera::BlockVectors& direction,
                    const BlockMask& active) {
  RayPacket rays;
  copy(rays.origin_x, origin.x), copy(rays.origin_y, origin.y), copy(rays.origin_z, origin.z);
  copy(rays.direction_x, direction.x), copy(rays.direction_y, direction.y), copy(rays.direction_z, direction.z);
  copy(rays.active, active);
  return rays;
}

void set_normal(const Eigen::Vector3d& normal_world, std::size_t lane, Block& block) {
  block.normal.x.at[lane] = static_cast<float>(normal_world.x());
  block.normal.y.at[lane] = static_cast<float>(normal_world.y());
  block.normal.z.at[lane] = static_cast<float>(normal_world.z());
}

}  // namespace

Tracer::Tracer(const CameraScene& scene, const Eigen::Vector3d& anchor_world_m, const PictureRequest& request)
    : world_(scene.world()),
      rays_(scene.rays_among(request.world_from_vehicles, request.hidden_vehicle, request.time_s)),
      record_(request.record),
      anchor_world_m_(anchor_world_m) {}

void Tracer::record(const RayPacket& rays, RayOrder order, int kind) const {
  record_->packets.push_back({kind + (order == RayOrder::kCoherent ? 2 : 0),
                              rays.active,
                              {rays.origin_x, rays.origin_y, rays.origin_z, rays.direction_x, rays.direction_y,
                               rays.direction_z, rays.near_m, rays.far_m}});
}

const camera::BlockFloats& Tracer::everywhere() {
  static const camera::BlockFloats all = [] {
    camera::BlockFloats far_m;
    std::ranges::fill(far_m.at, kFarthest_m);
    return far_m;
  }();
  return all;
}

void Tracer::cast(Block& block, const camera::BlockFloats& far_m, HitPacket& hits, RayOrder order) const {
  RayPacket rays = packet_of(block.origin, block.direction, block.active);
  rays.near_m.fill(0);
  copy(rays.far_m, far_m);
  if (record_ != nullptr) record(rays, order, 0);
  rays_.cast(anchor_world_m_, rays, hits, order);
  copy(block.distance, hits.distance_m);
  copy(block.label, hits.label);
  copy(block.primitive, hits.primitive);
  copy(block.normal.x, hits.normal_x), copy(block.normal.y, hits.normal_y), copy(block.normal.z, hits.normal_z);
}

void Tracer::locate_hits(const camera::View& view, const camera::Kernels& kernels, HitPacket& hits,
                         Block& block) const {
  unsigned has_solids = 0;  // without an early end, the compiler vectorizes the loop
  for (const std::uint32_t label : block.label) has_solids |= label > kTerrain ? 1u : 0u;
  if (has_solids != 0) refine(hits, block);
  kernels.locate_hits(view, block);
}

/// Recomputes distances to solids and vehicles, and their normals, in double precision: from the triangle that was hit,
/// which yields u and v as well, or, for vehicles and round shapes, by another cast.
void Tracer::refine(HitPacket& hits, Block& block) const {
  const auto solids_end = static_cast<std::uint32_t>(world_.solids().size() + kTerrain + 1);
  BlockMask again{};
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    if (block.label[k] <= kTerrain || hits.settled[k] != 0) continue;
    if (block.label[k] >= solids_end || (hits.u[k] == 0 && hits.v[k] == 0)) {
      again.at[k] = -1;
      continue;
    }
    const TriangleMesh& mesh = world_.solids()[block.label[k] - kTerrain - 1]->mesh_world;
    const Triangle& t = mesh.triangles[block.primitive[k]];
    const Eigen::Vector3d& a = mesh.vertices_m[t[0]];
    const Eigen::Vector3d ab = mesh.vertices_m[t[1]] - a, ac = mesh.vertices_m[t[2]] - a;
    const Eigen::Vector3d normal = ab.cross(ac);
    const double area = normal.norm();  // twice the area of the triangle
    if (area > 0) set_normal(normal / area, k, block);
    const Eigen::Vector3d direction(block.direction.x.at[k], block.direction.y.at[k], block.direction.z.at[k]);
    const Eigen::Vector3d from(block.origin.x.at[k], block.origin.y.at[k], block.origin.z.at[k]);
    const double along = normal.dot(direction);
    // Closer to tangency, the plane determines the distance less accurately than Embree does.
    if (std::abs(along) < kGrazingSine * area) continue;
    const Eigen::Vector3d to_a = a - anchor_world_m_ - from, moment = to_a.cross(direction);
    block.distance.at[k] = static_cast<float>(std::max(0.0, normal.dot(to_a) / along));
    hits.u[k] = static_cast<float>(ac.dot(moment) / along);
    hits.v[k] = static_cast<float>(-ab.dot(moment) / along);
  }
  if (any(again)) recast(again, block);
}

void Tracer::recast(const BlockMask& lanes, Block& block) const {
  std::array<Ray, kPacketRays> rays;
  std::array<RayHit, kPacketRays> hits;
  std::array<std::size_t, kPacketRays> lane_of;
  std::size_t count = 0;
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    if (!lanes.at[k]) continue;
    const Eigen::Vector3d from(block.origin.x.at[k], block.origin.y.at[k], block.origin.z.at[k]);
    const Eigen::Vector3d direction(block.direction.x.at[k], block.direction.y.at[k], block.direction.z.at[k]);
    rays[count] = {anchor_world_m_ + from, direction.normalized()};
    lane_of[count++] = k;
  }
  rays_.cast({rays.data(), count}, kRefineTo_m, {hits.data(), count});
  for (std::size_t k = 0; k < count; ++k) {
    if (!std::isfinite(hits[k].distance_m)) continue;
    block.distance.at[lane_of[k]] = static_cast<float>(hits[k].distance_m);
    set_normal(hits[k].normal_world.cast<double>(), lane_of[k], block);
  }
}

void Tracer::occluded(const Block& block, BlockMask& blocked, RayOrder order) const {
  RayPacket rays = packet_of(block.shadow_from, block.to_light, block.needs_shadow_ray);
  rays.near_m.fill(kShadowStart_m);
  copy(rays.far_m, block.light_distance);
  if (record_ != nullptr) record(rays, order, 1);
  std::array<std::int32_t, kPacketRays> found;
  rays_.occluded(anchor_world_m_, rays, found, order);
  copy(blocked, found);
}

}  // namespace uwsim
