#pragma once

#include <limits>
#include <optional>

#include "uwsim/rays/tile_surfaces.h"

namespace uwsim {

/// The result of a walk along a ray from cell to cell of a tile's terrain, in double.
struct TerrainWalk {
  std::optional<TileHit> hit;                                   ///< where the ray meets the terrain
  double clear_to_m = std::numeric_limits<double>::infinity();  ///< without a hit: the ray meets no terrain before
  bool began_low = false;                                       ///< the first point was not clear above the terrain
  bool near_solids = false;  ///< the walk went through a cell that a solid comes near
};

/// Walks from `from_m`, or from where the ray comes to lie over the tile's terrain, to where it meets the terrain (from
/// above or below), leaves the tile, or is higher above the terrain than the clearance.
TerrainWalk walk_terrain(const TileSurfaces& surfaces, const TileRay& ray, double from_m);

}  // namespace uwsim
