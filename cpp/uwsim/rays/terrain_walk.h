#pragma once

#include <limits>
#include <optional>

#include "uwsim/rays/tile_surfaces.h"

namespace uwsim {

/// The result of a walk along a ray from cell to cell of a tile's terrain, in double.
struct TerrainWalk {
  std::optional<TileHit> hit;  ///< where the ray hits the terrain
  /// If there is no hit: a distance before which the ray certainly does not hit the terrain
  double clear_to_m = std::numeric_limits<double>::infinity();
  bool began_low = false;    ///< whether the first point was not clearly above the terrain
  bool near_solids = false;  ///< whether the walk passed through a cell with a solid nearby
};

/// Walks along the ray from `from_m`, or from the point where the ray enters the space above the tile's terrain if that
/// is farther. The walk ends when the ray hits the terrain (from above or below), leaves the tile, or is higher above
/// the terrain than the clearance.
TerrainWalk walk_terrain(const TileSurfaces& surfaces, const TileRay& ray, double from_m);

}  // namespace uwsim
