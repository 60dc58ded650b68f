#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "uwsim/rays/tiling.h"

namespace uwsim {

// The terrain of a tile is passed to Embree as a raised sheet, so that no ray from above misses it because of float's
// error: the ray hits the raised sheet first, and from there it is followed to the terrain in double. Columns and rows
// count the vertices of the tile's block.

/// 1 / cosine of the block's steepest slope; 1 without terrain.
double steepest(const World& world, const TileContents& block);

/// The shift that moves a vertex to a distance of one metre from its steepest triangle, measured perpendicularly. At
/// the block's edges, the shift is also one metre outward, so that blocks overlap.
Eigen::Vector3d raise_per_metre(const World& world, const TileContents& block, std::uint32_t column, std::uint32_t row);

}  // namespace uwsim
