#pragma once

#include <cstdint>

namespace uwsim {

/// Embree's geometry number for a ray that hit nothing.
inline constexpr std::uint32_t kNoGeometry = ~0u;

/// A block of a height field's triangles, as numbered in Embree's tree: two per cell, cells row by row within the
/// block.
struct TerrainBlock {
  const float* heights_m;                                ///< of the whole height field
  double origin_x, origin_y;                             ///< of the whole height field [m]
  double cells_per_m;                                    ///< 1 / spacing
  double clearance_m;                                    ///< a point this far above it is above it for Embree as well
  std::uint32_t row_length;                              ///< number of vertices in a row of the whole height field
  std::uint32_t first_column, first_row, columns, rows;  ///< the block, in cells
};

/// Sixteen rays, as pointers to sixteen numbers each.
struct LaneRays {
  const double *origin_x, *origin_y, *origin_z, *direction_x, *direction_y, *direction_z, *far_m;
  const std::int32_t* active;
};

/// The same in float, relative to a point.
struct LaneFloats {
  float *origin_x, *origin_y, *origin_z, *direction_x, *direction_y, *direction_z, *far_m;
};

/// The terrain triangles that sixteen rays hit in float, and where their heights are.
struct TerrainLanes {
  alignas(64) std::int32_t on_terrain[16];  ///< -1 where the ray hit a triangle, else 0
  alignas(64) std::uint32_t triangle[16];   ///< within the block; 0 where it hit none
  alignas(64) std::int32_t vertex[16];      ///< at the right angle, within the whole height field
  alignas(64) std::int32_t far_corner[16];  ///< 1 where that is the cell's far corner, else 0
  alignas(64) std::int32_t column[16], row[16];
};

/// Embree's answer to sixteen rays: geometries, primitives and barycentric coordinates on these.
struct LaneAnswers {
  const std::uint32_t *geometry, *primitive;
  const float *u, *v;
};

/// Sixteen results. `met` is -1 where the ray hits its triangle at least `kCellMargin` from every edge and between 0
/// and far_m, else 0; there the distance is infinite and the normal zero.
struct LaneHits {
  double *distance_m, *normal_x, *normal_y, *normal_z;
  std::int32_t* met;
};

/// The loops over sixteen lanes, compiled for each instruction set. All give the same bits.
struct RayKernels {
  /// Whether every active ray starts within `distance_m` of the point along each axis.
  bool (*all_near)(const LaneRays& rays, const double* middle_m, double distance_m);
  /// low[k] is 0 if active ray k starts over the block and above all corners of its cell by the clearance, else -1.
  void (*find_low_starts)(const TerrainBlock& block, const LaneRays& rays, std::int32_t* low);
  /// Rays that start `setback_m` before their origins and reach a little farther than far_m.
  void (*to_float)(const LaneRays& rays, const double* middle_m, double setback_m, const LaneFloats& floats);
  /// passes[k] is 0 if ray k's line stays outside an infinite cylinder about an axis (point and unit direction; zero: a
  /// sphere about the point), else -1.
  void (*may_meet_round)(const LaneRays& rays, const double* point_m, const double* axis, double radius_m,
                         std::int32_t* passes);
  /// Numbers triangles where Embree's primitives are quads, two per quad: in the geometries `near_solids` and `open`.
  /// Sets all of `primitive`, and `on_terrain` and `triangle` of `terrain` where the quad is open terrain. Returns
  /// which of the two geometries were hit, as bits 1 and 2.
  int (*number_terrain)(const LaneAnswers& answers, std::uint32_t near_solids, std::uint32_t open,
                        std::uint32_t* primitive, TerrainLanes& terrain);
  /// Finds where the triangles' heights are and prefetches them for the refinement.
  void (*locate_heights)(const TerrainBlock& block, TerrainLanes& terrain);
  /// Solves ray k with the plane of triangle k in double (see terrain_hit.h).
  void (*refine_terrain)(const TerrainBlock& block, const TerrainLanes& terrain, const LaneRays& rays,
                         const LaneHits& hits);
  /// Labels the rays that hit that geometry with `open`, and the rest with 0; returns whether all of the rest hit
  /// nothing at all.
  bool (*label_terrain)(const std::uint32_t* geometry, std::uint32_t open, const std::int32_t* met,
                        std::uint32_t* label);
};

const RayKernels& baseline_ray_kernels();
const RayKernels& avx2_ray_kernels();
const RayKernels& avx512_ray_kernels();
/// The kernels for the widest instruction set of this processor.
const RayKernels& ray_kernels();

}  // namespace uwsim
