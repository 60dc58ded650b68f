#pragma once

#include <cstdint>
#include <vector>

#include "uwsim/rays/embree_round.h"
#include "uwsim/rays/embree_tree.h"
#include "uwsim/rays/tile_surfaces.h"

namespace uwsim {

/// A tile ready for rays: its surfaces in double, and the trees that Embree has built from them in float. It must not
/// be moved, because Embree's callbacks hold pointers to it.
struct TileTrees {
  TileSurfaces surfaces;
  TerrainBlock block{};                   ///< heights_m is null without terrain
  std::vector<RoundGeometry> round;       ///< data of the callbacks for round shapes
  std::vector<WidenedTriangles> widened;  ///< data of the filter for solids' triangles
  RayTree tree;                           ///< target of rays: raised terrain, widened triangles, round shapes
  /// For computing distances: the meshes of solids whose round shapes rays hit
  RayTree mesh_tree;
  std::vector<std::vector<std::uint8_t>> crowded;  ///< by geometry and primitive: whether another surface is near
  const RayKernels& kernels = ray_kernels();

  /// Throws InvalidValue if Embree cannot build its trees.
  TileTrees(RTCDeviceTy* device, const World& world, TileContents contents);
  TileTrees(const TileTrees&) = delete;
  TileTrees& operator=(const TileTrees&) = delete;

  bool is_crowded(std::uint32_t geometry, std::uint32_t primitive) const { return crowded[geometry][primitive] != 0; }
};

}  // namespace uwsim
