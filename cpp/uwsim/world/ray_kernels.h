#pragma once

#include <cstdint>

namespace uwsim {

/// A block of a height field's triangles, as the ray tree numbers them: two a cell, cells row by row within the block.
struct TerrainBlock {
  const float* heights_m;     ///< of the whole height field
  double origin_x, origin_y;  ///< of the whole height field [m]
  double cells_per_m;
  double margin_cells;                                   ///< how far inside its triangle a hit must lie
  double clearance_m;                                    ///< a ray that starts so high above it starts above it
  std::uint32_t row_length;                              ///< vertices in a row of the whole height field
  std::uint32_t first_column, first_row, columns, rows;  ///< the block, in cells
};

/// Sixteen rays, as pointers to sixteen numbers each.
struct LaneRays {
  const double *origin_x, *origin_y, *origin_z, *direction_x, *direction_y, *direction_z, *far_m;
  const std::int32_t* active;
};

/// The same in float about a point.
struct LaneFloats {
  float *origin_x, *origin_y, *origin_z, *direction_x, *direction_y, *direction_z, *far_m;
};

/// Of sixteen triangles: the vertex at the right angle, and whether that is the cell's far corner. `wanted`: -1 where
/// the lane has a triangle at all, else 0.
struct TerrainPlaces {
  alignas(64) std::int32_t wanted[16];
  alignas(64) std::int32_t vertex[16];
  alignas(64) std::int32_t far_corner[16];
  alignas(64) std::int32_t column[16], row[16];
};

/// What Embree names of sixteen rays: geometries, primitives and where on these.
struct NamedLanes {
  const std::uint32_t *geometry, *primitive;
  const float *u, *v;
};

/// Sixteen results. `met` is -1 where the ray meets its triangle at least the margin from every edge and between 0 and
/// far_m, else 0; and then the distance is infinite and the normal zero.
struct LaneHits {
  double *distance_m, *normal_x, *normal_y, *normal_z;
  std::int32_t* met;
};

/// The loops over sixteen lanes, compiled for one width of vector unit. All widths give the same bits.
struct RayKernels {
  /// Whether every active ray starts within `reach_m` of the point along each axis.
  bool (*all_near)(const LaneRays& rays, const double* middle_m, double reach_m);
  /// low[k] is 0 where active ray k starts over the block and above all corners of its cell by the clearance, else -1.
  void (*find_low)(const TerrainBlock& block, const LaneRays& rays, std::int32_t* low);
  /// Rays that start `back_m` before their origins; far_m a little enlarged: the exact limits are held to in double.
  void (*to_float)(const LaneRays& rays, const double* middle_m, double back_m, const LaneFloats& floats);
  /// passes[k] is 0 where ray k's line stays outside an endless cylinder about an axis (point and unit direction; zero:
  /// a sphere about the point), else -1.
  void (*may_meet_round)(const LaneRays& rays, const double* point_m, const double* axis, double radius_m,
                         std::int32_t* passes);
  /// Of quads of the geometries `crossed` and `plain`, the triangles: two a quad. Sets all of `primitive`; `triangle`
  /// where the quad is plain, else 0; and `wanted` there. Returns which of the two geometries are among them, as bits 1
  /// and 2.
  int (*name_triangles)(const NamedLanes& named, std::uint32_t crossed, std::uint32_t plain, std::uint32_t* primitive,
                        std::uint32_t* triangle, std::int32_t* wanted);
  /// Where the triangles' heights are, and asks the memory for them: the solution comes later.
  void (*locate)(const TerrainBlock& block, const std::uint32_t* triangles, TerrainPlaces& places);
  /// Meets ray k with triangle k's plane, in double. On a height field this needs no cross products: over its cell a
  /// triangle is a linear function, z = h + gx (x - x0) + gy (y - y0).
  void (*solve)(const TerrainBlock& block, const TerrainPlaces& places, const LaneRays& rays, const LaneHits& hits);
  /// Labels with `plain` what met that geometry, and with 0 the rest; returns whether all of those missed everything.
  bool (*label)(const std::uint32_t* geometry, std::uint32_t plain, const std::int32_t* met, std::uint32_t* label);
};

const RayKernels& baseline_ray_kernels();
const RayKernels& avx2_ray_kernels();
const RayKernels& avx512_ray_kernels();
/// The widest of these that this processor runs.
const RayKernels& ray_kernels();

}  // namespace uwsim
