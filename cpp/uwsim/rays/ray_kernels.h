#pragma once

#include <cstdint>

namespace uwsim {

/// Embree's geometry number for a ray that hit nothing.
inline constexpr std::uint32_t kNoGeometry = ~0u;

/// A block of a height field's triangles, as numbered in Embree's tree: two per cell, with cells row by row within the
/// block.
struct TerrainBlock {
  const float* heights_m;                                ///< of the whole height field
  double origin_x, origin_y;                             ///< of the whole height field [m]
  double cells_per_m;                                    ///< 1 / spacing
  double clearance_m;                                    ///< a point this far above is also above the raised terrain
  std::uint32_t row_length;                              ///< number of vertices in a row of the whole height field
  std::uint32_t first_column, first_row, columns, rows;  ///< the block, in cells
};

/// Sixteen rays, as pointers to sixteen values each.
struct LaneRays {
  const double *origin_x, *origin_y, *origin_z, *direction_x, *direction_y, *direction_z, *far_m;
  const std::int32_t* active;
};

/// Sixteen rays in float, relative to a point.
struct LaneFloats {
  float *origin_x, *origin_y, *origin_z, *direction_x, *direction_y, *direction_z, *far_m;
};

/// The terrain triangles that sixteen rays hit in float, and the locations of their heights.
struct TerrainLanes {
  alignas(64) std::int32_t on_terrain[16];  ///< -1 if the ray hit a triangle, else 0
  alignas(64) std::uint32_t triangle[16];   ///< within the block; 0 if the ray hit none
  alignas(64) std::int32_t vertex[16];      ///< vertex at the right angle, within the whole height field
  alignas(64) std::int32_t far_corner[16];  ///< 1 if that vertex is the cell's far corner, else 0
  alignas(64) std::int32_t column[16], row[16];
};

/// Embree's answer to sixteen rays: geometries, primitives and barycentric coordinates.
struct LaneAnswers {
  const std::uint32_t *geometry, *primitive;
  const float *u, *v;
};

/// Embree's answer to sixteen rays of a picture, to be completed in place; normals and directions are only read.
struct LaneFloatHits {
  const std::uint32_t* geometry;
  std::uint32_t *primitive, *label;
  float *u, *v, *distance_m;
  const float *normal_x, *normal_y, *normal_z, *direction_x, *direction_y, *direction_z;
};

/// The results for sixteen rays. `met` is -1 if the ray hits its triangle between 0 and far_m and at least
/// `kCellMargin` from every edge. Otherwise, `met` is 0, the distance is infinite and the normal is zero.
struct LaneHits {
  double *distance_m, *normal_x, *normal_y, *normal_z;
  std::int32_t* met;
};

/// Sixteen rays with the inverses of their directions and their limits, as pointers to sixteen values each.
struct LaneSlabs {
  const double *origin[3], *inverse[3], *near_m, *far_m;
  const std::int32_t* active;
};

/// A piece of pipe between two planes; see RoundShape, whose members these are.
struct LaneWall {
  const double *axis, *points_m[2], *outwards[2];
  double radius_m, seam_m, along_axis;
};

/// The result of intersecting a ray with a wall. A ray along the axis is left to the caller.
enum LaneMeeting : std::int32_t { kMisses = 0, kMeets = -1, kAlong = 1 };

/// The cone around a packet's active rays (RayBundle): its axis, and of all rays the least cosine to it, the greatest
/// square of an origin's distance from the first, and the farthest end; -infinity without any.
struct LaneBundle {
  double axis[3], cosine, spread2, far_m;
};

/// The loops over sixteen lanes, compiled for each instruction set. All versions produce the same bits.
struct RayKernels {
  /// Whether every active ray starts within `distance_m` of the point along each axis.
  bool (*all_near)(const LaneRays& rays, const double* middle_m, double distance_m);
  /// Sets low[k] to 0 if active ray k starts over the block and higher than all corners of the cell there by the
  /// clearance, else to -1.
  void (*find_low_starts)(const TerrainBlock& block, const LaneRays& rays, std::int32_t* low);
  /// Converts to float rays that start `setback_m` before their origins and reach slightly farther than far_m.
  void (*to_float)(const LaneRays& rays, const double* middle_m, double setback_m, const LaneFloats& floats);
  /// Shifts the origins of float rays (six rows of sixteen: origins, then directions) by (3,) and copies the others,
  /// with near and far, to the rows of Embree's packet of sixteen rays. Idle rays become finite: see embree_cast.h.
  void (*fill_packet)(const float* rays, const float* near_m, const float* far_m, const std::int32_t* active,
                      const float* shift, float* packet);
  /// Sets passes[k] to 0 if ray k's line stays outside an infinite cylinder, else to -1. The cylinder's axis is a point
  /// and a unit direction; if the direction is zero, the shape is a sphere about the point.
  void (*may_meet_round)(const LaneRays& rays, const double* point_m, const double* axis, double radius_m,
                         std::int32_t* passes);
  /// Intersects rays with the wall of a piece of pipe from `near_m` to rays.far_m, in double, with the bits of
  /// first_hit (world/round_shape.h). Sets met[k] to a LaneMeeting, and the other results where it is kMeets.
  void (*meet_wall)(const LaneRays& rays, const double* near_m, const LaneWall& wall, const LaneHits& hits);
  /// Replaces Embree's quads in the geometries `near_solids` and `open` by triangles, two per quad. Sets `primitive`
  /// for every lane, and `on_terrain` and `triangle` of `terrain` for quads of open terrain. Returns which of the two
  /// geometries were hit: 1 for `near_solids`, 2 for `open`.
  int (*number_terrain)(const LaneAnswers& answers, std::uint32_t near_solids, std::uint32_t open,
                        std::uint32_t* primitive, TerrainLanes& terrain);
  /// Completes Embree's answer for a picture: on terrain (geometries up to `terrain`), replaces quads and coordinates
  /// on them by triangles and barycentric coordinates, and moves each hit down by the raise to the plane of the true
  /// triangle, unless the ray grazes it. Sets the labels. Misses get an infinite distance, and label and primitive 0.
  /// Returns whether any ray hit something other than `terrain` itself.
  bool (*complete_floats)(const LaneFloatHits& hits, std::uint32_t terrain, float raise_m);
  /// Finds the locations of the triangles' heights and prefetches them for the refinement.
  void (*locate_heights)(const TerrainBlock& block, TerrainLanes& terrain);
  /// Intersects ray k with the plane of triangle k in double (see terrain_hit.h).
  void (*refine_terrain)(const TerrainBlock& block, const TerrainLanes& terrain, const LaneRays& rays,
                         const LaneHits& hits);
  /// Labels rays `open` if they hit that geometry and `met` is set, and all others 0. Returns true if all others hit
  /// nothing at all.
  bool (*label_terrain)(const std::uint32_t* geometry, std::uint32_t open, const std::int32_t* met,
                        std::uint32_t* label);
  /// Sets first_m[k] to where ray k enters a box (low and high: (3,)) between its limits, or to infinity if it does
  /// not. Returns the least of them.
  double (*enter_box)(const LaneSlabs& rays, const double* low, const double* high, double* first_m);
  /// The cone around rays (six rows of sixteen: origins, then directions), each as long as the lesser of two lengths.
  LaneBundle (*bundle_floats)(const float* rays, const float* far_m, const float* distance_m,
                              const std::int32_t* active);
  LaneBundle (*bundle_doubles)(const double* rays, const double* far_m, const double* distance_m,
                               const std::int32_t* active);
};

const RayKernels& baseline_ray_kernels();
const RayKernels& avx2_ray_kernels();
const RayKernels& avx512_ray_kernels();
/// The kernels for the widest instruction set that this processor supports.
const RayKernels& ray_kernels();

}  // namespace uwsim
