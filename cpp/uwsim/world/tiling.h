#pragma once

#include <vector>

#include "uwsim/world/tile_surfaces.h"

namespace uwsim {

inline constexpr double kTileWidth_m = 1000;

/// Cuts the world into tiles at most kTileWidth_m wide (or one cell of the terrain, where that is wider): blocks of
/// terrain cells, with the triangles and shapes whose middle lies over the block. Each belongs to one tile only.
std::vector<TileContents> cut_into_tiles(const World& world);

}  // namespace uwsim
