#pragma once

#include <cstdint>
#include <vector>

#include "uwsim/rays/embree_round.h"
#include "uwsim/rays/embree_tree.h"
#include "uwsim/rays/tile_surfaces.h"

namespace uwsim {

/// A tile ready for rays: its surfaces in double, and the trees that Embree built from them in float. It must not move,
/// since Embree's callbacks point into it.
struct TileTrees {
  TileSurfaces surfaces;
  TerrainBlock block{};                            ///< heights_m is null without terrain
  std::vector<RoundGeometry> round;                ///< what the callbacks of round shapes point to
  RayTree tree;                                    ///< what rays hit: raised terrain, widened triangles, round shapes
  RayTree mesh_tree;                               ///< the meshes of solids that rays hit as shapes, for distances
  std::vector<std::vector<std::uint8_t>> crowded;  ///< by geometry and primitive: whether another surface is near
  const RayKernels& kernels = ray_kernels();

  /// Throws InvalidValue if Embree cannot build its trees.
  TileTrees(RTCDeviceTy* device, const World& world, TileContents contents);
  TileTrees(const TileTrees&) = delete;
  TileTrees& operator=(const TileTrees&) = delete;

  bool is_crowded(std::uint32_t geometry, std::uint32_t primitive) const { return crowded[geometry][primitive] != 0; }
};

}  // namespace uwsim
