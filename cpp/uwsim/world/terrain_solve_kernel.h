#pragma once

#include <cmath>
#include <cstdint>

#include "uwsim/world/terrain_solve.h"

// Compiled once for each width of vector unit; hence the anonymous namespace, and loops that compilers vectorise.
namespace uwsim {
namespace {

inline void solve_terrain(const TerrainBlock& block, const std::uint32_t* triangles, const TerrainRays& rays,
                          const TerrainHits& hits) {
  constexpr int kLanes = 16;
  // Column and row by a multiplication: exact for whole numbers below 2^31, as half a cell is added.
  const double per_column = 1.0 / block.columns;
  alignas(64) std::int32_t corner[kLanes], upper[kLanes];  // the corner with the right angle; whether it is the far one
  alignas(64) double column[kLanes], row[kLanes];
  for (int k = 0; k < kLanes; ++k) {
    const auto cell = static_cast<std::int32_t>(triangles[k] >> 1);
    const auto j = static_cast<std::int32_t>((cell + 0.5) * per_column);
    const std::int32_t i = cell - j * static_cast<std::int32_t>(block.columns);
    upper[k] = static_cast<std::int32_t>(triangles[k] & 1);
    const std::int32_t u = i + static_cast<std::int32_t>(block.first_column) + upper[k];
    const std::int32_t v = j + static_cast<std::int32_t>(block.first_row) + upper[k];
    corner[k] = v * static_cast<std::int32_t>(block.row_length) + u;
    column[k] = u;
    row[k] = v;
  }
  alignas(64) float here[kLanes], along_x[kLanes], along_y[kLanes];
  const auto row_length = static_cast<std::int32_t>(block.row_length);
  for (int k = 0; k < kLanes; ++k) {
    const std::int32_t step = 1 - 2 * upper[k];
    here[k] = block.heights_m[corner[k]];
    along_x[k] = block.heights_m[corner[k] + step];
    along_y[k] = block.heights_m[corner[k] + step * row_length];
  }
  const double scale = block.cells_per_m, margin = block.margin_cells;
#pragma GCC ivdep  // results and rays are apart
  for (int k = 0; k < kLanes; ++k) {
    const double side = 1 - 2 * upper[k];
    const double slope_x = side * (static_cast<double>(along_x[k]) - here[k]);  // metres a cell
    const double slope_y = side * (static_cast<double>(along_y[k]) - here[k]);
    const double u = (rays.origin_x[k] - block.origin_x) * scale - column[k];
    const double v = (rays.origin_y[k] - block.origin_y) * scale - row[k];
    const double du = rays.direction_x[k] * scale, dv = rays.direction_y[k] * scale;
    const double distance =
        (here[k] + slope_x * u + slope_y * v - rays.origin_z[k]) / (rays.direction_z[k] - slope_x * du - slope_y * dv);
    const double a = side * (u + distance * du), b = side * (v + distance * dv);
    const double tilt_x = slope_x * scale, tilt_y = slope_y * scale;
    const double upright = 1 / std::sqrt(1 + tilt_x * tilt_x + tilt_y * tilt_y);
    hits.distance_m[k] = distance;
    hits.normal_x[k] = -tilt_x * upright;
    hits.normal_y[k] = -tilt_y * upright;
    hits.normal_z[k] = upright;
    hits.inside[k] = -static_cast<std::int32_t>((a >= margin) & (b >= margin) & (a + b <= 1 - margin));
  }
}

}  // namespace
}  // namespace uwsim
