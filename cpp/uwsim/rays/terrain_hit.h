#pragma once

#include <cstdint>

#include "uwsim/rays/ray_kernels.h"

// The refinement of a terrain hit: computes in double where a ray intersects the plane of a terrain triangle. The code
// is shared by the kernel that refines sixteen hits at a time and the walk from cell to cell, so that both produce the
// same bits. Kernels include this file, hence the anonymous namespace.
namespace uwsim {
namespace {

/// A terrain triangle, described relative to its vertex at the right angle; its legs run along a row and a column of
/// the grid. Within the cell, the triangle's plane is z = height + slope_x u + slope_y v, with u and v in cells from
/// that vertex, so intersecting it needs no cross products.
struct TerrainTriangle {
  /// 1 if the right angle is at the cell's corner and u, v increase along the legs; -1 if it is at the far corner
  double side;
  double column, row;       ///< of the vertex, in the whole height field
  double height_m;          ///< of the vertex
  double slope_x, slope_y;  ///< metres per cell
};

/// The intersection of a ray's line with the triangle's plane. a and b are measured along the legs in cells: the point
/// is on the triangle if neither is negative and their sum is at most 1.
struct PlaneHit {
  double distance_m, a, b;
};

/// Constructs the triangle from the heights of its vertex and of the ends of its legs.
inline TerrainTriangle terrain_triangle(double side, double column, double row, float height_m, float along_x_m,
                                        float along_y_m) {
  const double height = height_m;
  return {side, column, row, height, side * (along_x_m - height), side * (along_y_m - height)};
}

inline PlaneHit meet_plane(const TerrainTriangle& triangle, const TerrainBlock& block, double origin_x, double origin_y,
                           double origin_z, double direction_x, double direction_y, double direction_z) {
  // The ray in cells, relative to the vertex.
  const double u = (origin_x - block.origin_x) * block.cells_per_m - triangle.column;
  const double v = (origin_y - block.origin_y) * block.cells_per_m - triangle.row;
  const double du = direction_x * block.cells_per_m, dv = direction_y * block.cells_per_m;
  // The height of the plane above the ray's origin, divided by the rate at which the ray approaches the plane.
  const double distance_m = (triangle.height_m + triangle.slope_x * u + triangle.slope_y * v - origin_z) /
                            (direction_z - triangle.slope_x * du - triangle.slope_y * dv);
  return {distance_m, triangle.side * (u + distance_m * du), triangle.side * (v + distance_m * dv)};
}

}  // namespace
}  // namespace uwsim
