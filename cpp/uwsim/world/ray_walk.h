#pragma once

#include <limits>
#include <optional>

#include "uwsim/world/tile_surfaces.h"

namespace uwsim {

/// What becomes of a ray that is followed from cell to cell of a tile's terrain, in double.
struct TerrainWalk {
  std::optional<TileHit> hit;                                   ///< where it meets the terrain
  double clear_to_m = std::numeric_limits<double>::infinity();  ///< without a hit: it meets none before
  bool set_out = false;                                         ///< it was not clear of the terrain from the start
  bool crossed = false;                                         ///< through a cell that a solid comes near
};

/// From `from_m` on, or from where the ray comes to lie over the terrain, to where it meets it (from above or below),
/// leaves it, or is more than `clearance_m` above it.
TerrainWalk walk_terrain(const TileSurfaces& surfaces, const TileRay& ray, double from_m);

}  // namespace uwsim
