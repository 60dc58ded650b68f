#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>

#include "uwsim/world/ray_packet.h"
#include "uwsim/world/tile_surfaces.h"

struct RTCDeviceTy;
struct RTCSceneTy;

namespace uwsim {

struct ReleaseDevice {
  void operator()(RTCDeviceTy* device) const;
};
struct ReleaseScene {
  void operator()(RTCSceneTy* scene) const;
};
using RayDevice = std::unique_ptr<RTCDeviceTy, ReleaseDevice>;
using RayTree = std::unique_ptr<RTCSceneTy, ReleaseScene>;

/// What Embree's callbacks are told about the rays they get, by what follows the RTCIntersectContext: lane `id` of
/// `exact` that starts `starts_m[id]` along its way (0 when null); with `exact` null, only what the float ray says.
struct RayDetail {
  const TileSurfaces* surfaces;
  const ExactRays* exact;
  const double* starts_m;
};

/// One round solid within a tile, as its callbacks know it. It must outlive the tree.
struct RoundGeometry {
  const TileSurfaces* surfaces;
  std::uint32_t geometry;
};

RayDevice make_ray_device();
/// Robust trees do not let rays leak through edges.
RayTree make_ray_tree(RTCDeviceTy* device, bool robust);
/// Builds the tree. Throws InvalidValue when Embree cannot: it would go on with a world that has holes.
void commit(RTCDeviceTy* device, RTCSceneTy* tree, std::size_t triangles);

/// Triangles widened by the tile's reach; geometry and primitive numbers are the surfaces'.
void attach_triangles(RTCDeviceTy* device, RTCSceneTy* tree, const TileSurfaces& surfaces, std::uint32_t geometry);
/// The triangles of a mesh that rays meet as shapes; primitive numbers count within the share.
void attach_mesh(RTCDeviceTy* device, RTCSceneTy* tree, const TileSurfaces& surfaces, std::size_t mesh);
void attach_round(RTCDeviceTy* device, RTCSceneTy* tree, const RoundGeometry& round);

/// The least of `nearest_m` and the distance to a triangle of the tree; of shapes it knows nothing.
double nearest_triangle_m(RTCSceneTy* tree, const TileSurfaces& surfaces, bool meshes,
                          const Eigen::Vector3d& point_world_m, double nearest_m);

}  // namespace uwsim
