#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "uwsim/world/ray_packet.h"
#include "uwsim/world/tile_surfaces.h"

struct RTCDeviceTy;
struct RTCGeometryTy;
struct RTCIntersectContext;
struct RTCSceneTy;
struct RTCRay16;
struct RTCRayHit;
struct RTCRayHit16;

namespace uwsim {

struct ReleaseDevice {
  void operator()(RTCDeviceTy* device) const;
};
struct ReleaseGeometry {
  void operator()(RTCGeometryTy* geometry) const;
};
struct ReleaseScene {
  void operator()(RTCSceneTy* scene) const;
};
using RayDevice = std::unique_ptr<RTCDeviceTy, ReleaseDevice>;
using GeometryOwner = std::unique_ptr<RTCGeometryTy, ReleaseGeometry>;
using RayTree = std::unique_ptr<RTCSceneTy, ReleaseScene>;

/// A packet's rays in double, made when they are first asked for: most packets meet nothing round.
struct LateRays {
  const Eigen::Vector3d& anchor_world_m;
  const RayPacket& rays;
  bool made = false;
  ExactRays exact;

  LateRays(const Eigen::Vector3d& anchor, const RayPacket& of) : anchor_world_m(anchor), rays(of) {}
  const ExactRays& get();
};

/// What the callbacks of round solids know of the rays they get: lane `id` of `exact` that starts `starts_m[id]` along
/// its way (0 when null); with `exact` null, only what the float ray says.
struct RayDetail {
  const TileSurfaces* surfaces;
  const ExactRays* exact;
  const double* starts_m;
  double back_m = 0;                ///< so much sooner the float rays start
  ExactHits* round_hits = nullptr;  ///< takes the exact distance and normal of each round hit, by lane, if not null
  LateRays* late = nullptr;         ///< where `exact` is null, gives it once a round solid asks
};

/// What `intersect` and `occluded` let Embree's callbacks know.
const RayDetail& detail_of(const RTCIntersectContext* context);

inline LaneRays lanes_of(const ExactRays& rays) {
  return {rays.origin_x.data(),    rays.origin_y.data(),    rays.origin_z.data(), rays.direction_x.data(),
          rays.direction_y.data(), rays.direction_z.data(), rays.far_m.data(),    rays.active.data()};
}

/// One round solid within a tile, as its callbacks know it: its shapes by primitive. It must outlive the tree.
struct RoundGeometry {
  std::uint32_t geometry;
  std::vector<RoundShape> shapes;
  Eigen::Vector3d middle_m;
  double room_m;  ///< about each
};

RayDevice make_ray_device();
/// Robust trees do not let rays leak through edges.
RayTree make_ray_tree(RTCDeviceTy* device, bool robust);
/// Builds the tree. Throws InvalidValue when Embree cannot: it would go on with a world that has holes.
void commit(RTCDeviceTy* device, RTCSceneTy* tree, std::size_t triangles);

/// A solid's triangles, widened by the tile's rim; geometry and primitive numbers are the surfaces'.
void attach_triangles(RTCDeviceTy* device, RTCSceneTy* tree, const TileSurfaces& surfaces, std::uint32_t geometry);
/// The triangles of a mesh that rays meet as shapes; primitive numbers count within the share.
void attach_mesh(RTCDeviceTy* device, RTCSceneTy* tree, const TileSurfaces& surfaces, std::size_t mesh);
void attach_round(RTCDeviceTy* device, RTCSceneTy* tree, const RoundGeometry& round);

/// Casts through a tree that may hold round solids; hit fields are to be invalid before.
void intersect(RTCSceneTy* tree, const RayDetail& detail, RayOrder order, const std::int32_t* active,
               RTCRayHit16& packet);
void intersect(RTCSceneTy* tree, const RayDetail& detail, RTCRayHit& ray);
void occluded(RTCSceneTy* tree, const RayDetail& detail, RayOrder order, const std::int32_t* active, RTCRay16& packet);

}  // namespace uwsim
