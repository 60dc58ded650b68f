#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "uwsim/rays/tiling.h"

namespace uwsim {

// Embree gets the terrain of a tile raised as one sheet, so that no ray from above misses it because of float's error:
// the ray hits the raised sheet first, and is followed in double from there to the terrain. Columns and rows count the
// vertices of the tile's block.

/// 1 / cosine of the block's steepest slope; 1 without terrain.
double steepest(const World& world, const TileContents& block);

/// The shift that moves a vertex one metre off its steepest triangle, measured perpendicularly; at the block's edges,
/// also one metre outward, so that blocks overlap.
Eigen::Vector3d raise_per_metre(const World& world, const TileContents& block, std::uint32_t column, std::uint32_t row);

}  // namespace uwsim
