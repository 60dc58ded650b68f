#include "uwsim/rays/raised_terrain.h"

#include <algorithm>
#include <cmath>

namespace uwsim {
namespace {

/// 1 / cosine of the slope of the triangle whose right angle is at a vertex of the block, and whose legs run towards
/// higher columns and rows (side 1) or lower ones (-1).
double steepness(const Heightfield& terrain, const TileContents& block, std::uint32_t column, std::uint32_t row,
                 int side) {
  const float* here = &terrain.heights_m()[(block.first_row + row) * terrain.nx() + block.first_column + column];
  const double x = (double{here[side]} - *here) / terrain.spacing_m();
  const double y = (double{here[side * static_cast<std::ptrdiff_t>(terrain.nx())]} - *here) / terrain.spacing_m();
  return std::sqrt(1 + x * x + y * y);
}

/// The largest steepness of the triangles around a vertex of the block.
double steepest_at(const Heightfield& terrain, const TileContents& block, std::uint32_t column, std::uint32_t row) {
  const auto at = [&](std::uint32_t i, std::uint32_t j, int side) { return steepness(terrain, block, i, j, side); };
  double most = 1;
  const bool left = column > 0, right = column<block.columns, below = row> 0, above = row < block.rows;
  if (right && above) most = std::max(most, at(column, row, 1));
  if (left && below) most = std::max(most, at(column, row, -1));
  if (left && above) most = std::max({most, at(column - 1, row, 1), at(column, row + 1, -1)});
  if (right && below) most = std::max({most, at(column, row - 1, 1), at(column + 1, row, -1)});
  return most;
}

}  // namespace

double steepest(const World& world, const TileContents& block) {
  double most = 1;
  for (std::uint32_t j = 0; j < block.rows; ++j) {
    for (std::uint32_t i = 0; i < block.columns; ++i) {
      most = std::max(
          {most, steepness(*world.terrain(), block, i, j, 1), steepness(*world.terrain(), block, i + 1, j + 1, -1)});
    }
  }
  return most;
}

Eigen::Vector3d raise_per_metre(const World& world, const TileContents& block, std::uint32_t column,
                                std::uint32_t row) {
  const auto outward = [](std::uint32_t at, std::uint32_t last) { return at == 0 ? -1.0 : at == last ? 1.0 : 0.0; };
  Eigen::Vector3d shift(outward(column, block.columns), outward(row, block.rows), 0);
  // Where the terrain rises outward, moving a vertex outward brings the sheet closer to the terrain; raising it further
  // compensates for that.
  const double steep = steepest_at(*world.terrain(), block, column, row), slope = std::sqrt(steep * steep - 1);
  shift.z() = steep + slope * (std::abs(shift.x()) + std::abs(shift.y()));
  return shift;
}

}  // namespace uwsim
