#pragma once

#include <cstdint>
#include <vector>

#include "uwsim/world/world.h"

namespace uwsim {

inline constexpr double kTileWidth_m = 1000;

/// The part of the world that a tile holds: a block of the terrain's cells; of each solid the triangles or round shapes
/// that rays meet; and, where those are shapes, the triangles of its mesh too.
struct TileContents {
  /// Members count within the solid: triangles of its mesh, or shapes.
  struct Share {
    Label label;
    std::vector<std::uint32_t> members;
  };
  std::uint32_t first_column = 0, first_row = 0, columns = 0, rows = 0;  ///< the block, in cells
  std::vector<Share> solids;
  std::vector<Share> meshes;  ///< of solids that rays meet as shapes
};

/// Cuts the world into tiles at most kTileWidth_m wide (or one cell of the terrain, where that is wider): blocks of
/// terrain cells, with the triangles and shapes whose middle lies over the block. Each belongs to one tile only. Solids
/// of very small triangles have smaller tiles of their own, in which float can tell these apart.
std::vector<TileContents> cut_into_tiles(const World& world);

}  // namespace uwsim
