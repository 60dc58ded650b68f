#pragma once

#include <cstdint>

namespace uwsim {

/// A block of a height field's triangles, as the ray tree numbers them: two a cell, cells row by row within the block.
struct TerrainBlock {
  const float* heights_m;     ///< of the whole height field
  double origin_x, origin_y;  ///< of the whole height field [m]
  double cells_per_m;
  double margin_cells;                             ///< how far inside its triangle a hit must lie
  std::uint32_t row_length;                        ///< vertices in a row of the whole height field
  std::uint32_t first_column, first_row, columns;  ///< the block, in cells
};

/// Sixteen rays, as pointers to sixteen numbers each.
struct TerrainRays {
  const double *origin_x, *origin_y, *origin_z, *direction_x, *direction_y, *direction_z;
};

/// Sixteen results. `inside` is -1 where the ray meets its triangle at least the margin from every edge, else 0 (and
/// then nothing else is said).
struct TerrainHits {
  double *distance_m, *normal_x, *normal_y, *normal_z;
  std::int32_t* inside;
};

/// Meets ray k with triangle k's plane, in double. On a height field this needs no cross products: over its cell a
/// triangle is a linear function, z = h + gx (x - x0) + gy (y - y0).
using TerrainSolve = void (*)(const TerrainBlock& block, const std::uint32_t* triangles, const TerrainRays& rays,
                              const TerrainHits& hits);

void solve_terrain_baseline(const TerrainBlock&, const std::uint32_t*, const TerrainRays&, const TerrainHits&);
void solve_terrain_avx2(const TerrainBlock&, const std::uint32_t*, const TerrainRays&, const TerrainHits&);
void solve_terrain_avx512(const TerrainBlock&, const std::uint32_t*, const TerrainRays&, const TerrainHits&);

/// The widest of these that this processor runs; all give the same bits.
TerrainSolve best_terrain_solve();

}  // namespace uwsim
