#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "uwsim/rays/tile_surfaces.h"

struct RTCDeviceTy;
struct RTCGeometryTy;
struct RTCSceneTy;

namespace uwsim {

struct ReleaseDevice {
  void operator()(RTCDeviceTy* device) const;
};
struct ReleaseGeometry {
  void operator()(RTCGeometryTy* geometry) const;
};
struct ReleaseTree {
  void operator()(RTCSceneTy* tree) const;
};
using RayDevice = std::unique_ptr<RTCDeviceTy, ReleaseDevice>;
using GeometryOwner = std::unique_ptr<RTCGeometryTy, ReleaseGeometry>;
using RayTree = std::unique_ptr<RTCSceneTy, ReleaseTree>;

RayDevice make_ray_device();
/// Creates an empty tree. In robust trees, no ray slips between neighbouring triangles.
RayTree make_ray_tree(RTCDeviceTy* device, bool robust);
/// Builds the tree. Throws InvalidValue if Embree fails, because Embree would continue with holes in the world.
void commit(RTCDeviceTy* device, RTCSceneTy* tree, std::size_t triangles);

/// Adds a finished geometry to a tree, under its number.
void attach(RTCSceneTy* tree, const GeometryOwner& geometry, std::uint32_t geometry_id);
/// The widened triangles of one solid within a tile, for Embree's filter. It must outlive the tree.
struct WidenedTriangles {
  const TileSurfaces& surfaces;
  std::vector<float> margin = {};  ///< by primitive, see margin_within
};
/// Adds a solid's triangles, widened; geometry and primitive numbers are surface numbers. Sets their margins.
void attach_triangles(RTCDeviceTy* device, RTCSceneTy* tree, std::uint32_t geometry, WidenedTriangles& triangles);
/// Adds the mesh of a solid whose round shapes rays hit instead; primitives are numbered within the tile's share of the
/// mesh.
void attach_mesh(RTCDeviceTy* device, RTCSceneTy* tree, const TileSurfaces& surfaces, std::size_t mesh);

}  // namespace uwsim
