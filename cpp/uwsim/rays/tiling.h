#pragma once

#include <cstdint>
#include <vector>

#include "uwsim/world/world.h"

namespace uwsim {

inline constexpr double kTileWidth_m = 1000;

/// The part of the world in one tile: a block of the terrain's cells; for each solid, the triangles or round shapes
/// that rays hit; and, if those are shapes, also the triangles of its mesh.
struct TileContents {
  /// The part of one solid in a tile. Members are indices of triangles of the solid's mesh, or of its shapes.
  struct Share {
    Label label;
    std::vector<std::uint32_t> members;
  };
  std::uint32_t first_column = 0, first_row = 0, columns = 0, rows = 0;  ///< the block, in cells
  std::vector<Share> solids;
  std::vector<Share> meshes;  ///< triangles of solids whose shapes rays hit
};

/// Divides the world into tiles at most kTileWidth_m wide (or one terrain cell, if that is wider): blocks of terrain
/// cells, with the triangles and shapes whose middle lies above the block. Each triangle or shape belongs to one tile
/// only. Solids with very small triangles have separate, smaller tiles, in which float can distinguish the triangles.
std::vector<TileContents> cut_into_tiles(const World& world);

}  // namespace uwsim
