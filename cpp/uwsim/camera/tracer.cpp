#include "uwsim/camera/tracer.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "uwsim/camera/block_mask.h"
#include "uwsim/core/check.h"
#include "uwsim/rays/tolerances.h"

namespace uwsim {
namespace {

using camera::Block;
using camera::BlockMask;

constexpr float kFarthest_m = 1e5f;
constexpr float kNearest_m = 1e-3f;  // keeps a shadow ray from hitting its own surface
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

}  // namespace

Tracer::Tracer(const CameraScene& scene, const Eigen::Vector3d& anchor_world_m, const PictureRequest& request)
    : world_(scene.world()), rays_(scene.rays()), record_(request.record), anchor_world_m_(anchor_world_m) {
  const std::size_t poses = request.world_from_vehicles.size();
  require(poses == 0 || poses == scene.vehicles().size(), "vehicles", poses,
          "must be a pose for each vehicle, or none");
  const auto first_label = static_cast<std::uint32_t>(scene.world().solids().size() + kTerrain + 1);
  for (std::size_t k = 0; k < poses; ++k) {
    if (request.hidden_vehicle == k) continue;
    const VehicleHull& vehicle = scene.vehicles()[k];
    const Pose& pose = request.world_from_vehicles[k];
    const Pose body_from_world = pose.inverse();
    hulls_.push_back({vehicle.hull.get(), first_label + static_cast<std::uint32_t>(k), body_from_world,
                      body_from_world.rotation().cast<float>(), body_from_world.point(anchor_world_m_),
                      (pose.point(vehicle.centre_body_m) - anchor_world_m_).cast<float>(),
                      static_cast<float>(vehicle.radius_m)});
  }
}

void Tracer::record(const RayPacket& rays, RayOrder order, int kind) const {
  record_->packets.push_back({kind + (order == RayOrder::kCoherent ? 2 : 0),
                              rays.active,
                              {rays.origin_x, rays.origin_y, rays.origin_z, rays.direction_x, rays.direction_y,
                               rays.direction_z, rays.near_m, rays.far_m}});
}

bool Tracer::may_hit(const RayPacket& rays, const PlacedHull& hull) {
  int near = 0;
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    const float x = hull.centre_m.x() - rays.origin_x[k], y = hull.centre_m.y() - rays.origin_y[k];
    const float z = hull.centre_m.z() - rays.origin_z[k];
    const float along = x * rays.direction_x[k] + y * rays.direction_y[k] + z * rays.direction_z[k];
    const float apart2 = x * x + y * y + z * z - along * along;
    near |= rays.active[k] & static_cast<int>(apart2 < hull.radius_m * hull.radius_m && along > -hull.radius_m &&
                                              along < rays.far_m[k] + hull.radius_m);
  }
  return near != 0;
}

RayPacket Tracer::in_body_frame(const RayPacket& rays, const PlacedHull& hull) {
  RayPacket turned = rays;
  const Eigen::Matrix3f& rotation = hull.body_from_world_rotation;
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    const Eigen::Vector3f origin = rotation * Eigen::Vector3f(rays.origin_x[k], rays.origin_y[k], rays.origin_z[k]);
    const Eigen::Vector3f direction =
        rotation * Eigen::Vector3f(rays.direction_x[k], rays.direction_y[k], rays.direction_z[k]);
    turned.origin_x[k] = origin.x(), turned.origin_y[k] = origin.y(), turned.origin_z[k] = origin.z();
    turned.direction_x[k] = direction.x(), turned.direction_y[k] = direction.y(), turned.direction_z[k] = direction.z();
  }
  return turned;
}

void Tracer::cast(Block& block, HitPacket& hits, RayOrder order) const {
  RayPacket rays = packet_of(block.origin, block.direction, block.active);
  rays.near_m.fill(0);
  rays.far_m.fill(kFarthest_m);
  if (record_ != nullptr) record(rays, order, 0);
  rays_.cast(anchor_world_m_, rays, hits, order);
  for (const PlacedHull& hull : hulls_) {
    if (!may_hit(rays, hull)) continue;
    HitPacket own;
    hull.rays->cast(hull.anchor_body_m, in_body_frame(rays, hull), own, order);
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      if (!rays.active[k] || !(own.distance_m[k] < hits.distance_m[k])) continue;
      const Eigen::Vector3f normal = hull.body_from_world_rotation.transpose() *
                                     Eigen::Vector3f(own.normal_x[k], own.normal_y[k], own.normal_z[k]);
      hits.distance_m[k] = own.distance_m[k];
      hits.label[k] = hull.label;
      hits.primitive[k] = own.primitive[k];
      hits.normal_x[k] = normal.x(), hits.normal_y[k] = normal.y(), hits.normal_z[k] = normal.z();
    }
  }
  copy(block.distance, hits.distance_m);
  copy(block.label, hits.label);
  copy(block.primitive, hits.primitive);
  copy(block.normal.x, hits.normal_x), copy(block.normal.y, hits.normal_y), copy(block.normal.z, hits.normal_z);
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    block.distance.at[k] = rays.active[k] ? block.distance.at[k] : std::numeric_limits<float>::infinity();
    block.label[k] = rays.active[k] ? block.label[k] : kNothing;
  }
}

void Tracer::refine(const HitPacket& hits, Block& block) const {
  refine_solids(hits, block);
  for (const PlacedHull& hull : hulls_) {
    BlockMask lanes{};
    for (std::size_t k = 0; k < kPacketRays; ++k) lanes.at[k] = block.label[k] == hull.label ? -1 : 0;
    if (any(lanes)) recast(*hull.rays, lanes, &hull, block);
  }
}

void Tracer::refine_solids(const HitPacket& hits, Block& block) const {
  const auto solids_end = static_cast<std::uint32_t>(world_.solids().size() + kTerrain + 1);
  BlockMask round{};
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    if (block.label[k] <= kTerrain || block.label[k] >= solids_end || hits.settled[k] != 0) continue;
    if (hits.u[k] == 0 && hits.v[k] == 0) {
      round.at[k] = -1;
      continue;
    }
    const TriangleMesh& mesh = world_.solids()[block.label[k] - kTerrain - 1]->mesh_world;
    const Triangle& t = mesh.triangles[block.primitive[k]];
    const Eigen::Vector3d a = mesh.vertices_m[t[0]] - anchor_world_m_;
    const Eigen::Vector3d normal =
        (mesh.vertices_m[t[1]] - mesh.vertices_m[t[0]]).cross(mesh.vertices_m[t[2]] - mesh.vertices_m[t[0]]);
    const Eigen::Vector3d direction(block.direction.x.at[k], block.direction.y.at[k], block.direction.z.at[k]);
    const Eigen::Vector3d from(block.origin.x.at[k], block.origin.y.at[k], block.origin.z.at[k]);
    const double along = normal.dot(direction);
    // Closer to tangency the plane determines the distance less well than Embree does.
    if (std::abs(along) < kGrazingSine * normal.norm()) continue;
    block.distance.at[k] = static_cast<float>(std::max(0.0, normal.dot(a - from) / along));
  }
  if (any(round)) recast(rays_, round, nullptr, block);
}

void Tracer::recast(const RayScene& scene, const BlockMask& lanes, const PlacedHull* hull, Block& block) const {
  std::array<Ray, kPacketRays> rays;
  std::array<RayHit, kPacketRays> hits;
  std::array<std::size_t, kPacketRays> lane_of;
  std::size_t count = 0;
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    if (!lanes.at[k]) continue;
    const Eigen::Vector3d from(block.origin.x.at[k], block.origin.y.at[k], block.origin.z.at[k]);
    const Eigen::Vector3d direction(block.direction.x.at[k], block.direction.y.at[k], block.direction.z.at[k]);
    rays[count] = {anchor_world_m_ + from, direction.normalized()};
    if (hull != nullptr) {
      rays[count] = {hull->body_from_world.point(rays[count].origin_world_m),
                     hull->body_from_world.direction(rays[count].direction_world)};
    }
    lane_of[count++] = k;
  }
  scene.cast({rays.data(), count}, kRefineTo_m, {hits.data(), count});
  for (std::size_t k = 0; k < count; ++k) {
    if (std::isfinite(hits[k].distance_m)) block.distance.at[lane_of[k]] = static_cast<float>(hits[k].distance_m);
  }
}

void Tracer::occluded(const Block& block, BlockMask& blocked, RayOrder order) const {
  RayPacket rays = packet_of(block.point, block.to_light, block.needs_shadow_ray);
  rays.near_m.fill(kNearest_m);
  copy(rays.far_m, block.light_distance);
  // Start off the surface, on the eye's side. Inactive lanes, whose distance may be infinite, must be finite, too:
  // without AVX-512 Embree splits packets of sixteen, and Debian's ends the process if they are not.
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    const float lift = 1e-3f + 2e-5f * std::min(block.distance.at[k], kFarthest_m);
    rays.origin_x[k] += lift * block.normal.x.at[k];
    rays.origin_y[k] += lift * block.normal.y.at[k];
    rays.origin_z[k] += lift * block.normal.z.at[k];
  }
  if (record_ != nullptr) record(rays, order, 1);
  std::array<std::int32_t, kPacketRays> found;
  rays_.occluded(anchor_world_m_, rays, found, order);
  copy(blocked, found);
  for (const PlacedHull& hull : hulls_) {
    if (!may_hit(rays, hull)) continue;
    hull.rays->occluded(hull.anchor_body_m, in_body_frame(rays, hull), found, order);
    for (std::size_t k = 0; k < kPacketRays; ++k) blocked.at[k] |= found[k];
  }
}

}  // namespace uwsim
