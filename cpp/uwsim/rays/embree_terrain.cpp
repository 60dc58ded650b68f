#include "uwsim/rays/embree_terrain.h"

#include <limits>

#include "uwsim/core/check.h"
#include "uwsim/rays/embree.h"
#include "uwsim/rays/embree_cast.h"
#include "uwsim/rays/embree_tree.h"
#include "uwsim/rays/raised_terrain.h"
#include "uwsim/rays/terrain_walk.h"

namespace uwsim {
namespace {

constexpr std::uint32_t kCorners = 4;

struct Quads {
  float* vertex;
  std::uint32_t* index;
};

void put(const Eigen::Vector3d& point, float* vertex) {
  for (int axis = 0; axis < 3; ++axis) vertex[axis] = static_cast<float>(point(axis));
}

/// A raised vertex of the block, relative to the tile's middle.
Eigen::Vector3d raised_vertex_m(const TileSurfaces& surfaces, std::uint32_t column, std::uint32_t row) {
  const TileContents& block = surfaces.contents();
  const Heightfield& terrain = *surfaces.world().terrain();
  const std::size_t number = (block.first_row + row) * terrain.nx() + block.first_column + column;
  return terrain.vertex(number) - surfaces.middle_m() +
         surfaces.tolerances().raise_m * raise_per_metre(surfaces.world(), block, column, row);
}

/// Adds the block's cells, which share the block's vertices. Cells near solids get a NaN vertex, so that Embree omits
/// them.
void fill_open_terrain(const TileSurfaces& surfaces, const Quads& quads) {
  const TileContents& block = surfaces.contents();
  const std::uint32_t row_length = block.columns + 1, nowhere = row_length * (block.rows + 1);
  float* vertex = quads.vertex;
  for (std::uint32_t j = 0; j <= block.rows; ++j) {
    for (std::uint32_t i = 0; i <= block.columns; ++i, vertex += 3) put(raised_vertex_m(surfaces, i, j), vertex);
  }
  put(Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()), vertex);
  std::uint32_t* index = quads.index;
  for (std::uint32_t cell = 0; cell < block.columns * block.rows; ++cell, index += kCorners) {
    const std::uint32_t corner = cell / block.columns * row_length + cell % block.columns;
    const bool left_out = surfaces.is_near_solids(cell);
    index[0] = left_out ? nowhere : corner;
    index[1] = left_out ? nowhere : corner + 1;
    index[2] = left_out ? nowhere : corner + row_length + 1;
    index[3] = left_out ? nowhere : corner + row_length;
  }
}

/// Adds the cells near solids, which do not share vertices.
void fill_terrain_near_solids(const TileSurfaces& surfaces, std::uint32_t cells, const Quads& quads) {
  for (std::uint32_t k = 0; k < cells; ++k) {
    const std::uint32_t cell = surfaces.block_triangle(2 * k) / 2;
    const std::uint32_t i = cell % surfaces.contents().columns, j = cell / surfaces.contents().columns;
    float* vertex = quads.vertex + 3 * kCorners * k;
    put(raised_vertex_m(surfaces, i, j), vertex);
    put(raised_vertex_m(surfaces, i + 1, j), vertex + 3);
    put(raised_vertex_m(surfaces, i + 1, j + 1), vertex + 6);
    put(raised_vertex_m(surfaces, i, j + 1), vertex + 9);
  }
  for (std::uint32_t k = 0; k < kCorners * cells; ++k) quads.index[k] = k;
}

/// Embree's filter for shadow rays. At a cliff, the raised terrain is high above the true terrain. A ray that starts
/// between the two passes through the raised terrain from below, so it is blocked only if it hits the true terrain.
void let_out_through_raised_terrain(const RTCFilterFunctionNArguments* args) {
  const TileSurfaces& surfaces = *detail_of(args->context).surfaces;
  RTCRayN* rays = args->ray;
  for (unsigned k = 0; k < args->N; ++k) {
    const Eigen::Vector3f up(RTCHitN_Ng_x(args->hit, args->N, k), RTCHitN_Ng_y(args->hit, args->N, k),
                             RTCHitN_Ng_z(args->hit, args->N, k));
    const Eigen::Vector3f direction(RTCRayN_dir_x(rays, args->N, k), RTCRayN_dir_y(rays, args->N, k),
                                    RTCRayN_dir_z(rays, args->N, k));
    if (args->valid[k] == 0 || up.dot(direction) <= 0) continue;
    const Eigen::Vector3f origin(RTCRayN_org_x(rays, args->N, k), RTCRayN_org_y(rays, args->N, k),
                                 RTCRayN_org_z(rays, args->N, k));
    const TileRay ray{surfaces.middle_m() + origin.cast<double>(), direction.cast<double>(),
                      RTCRayN_tfar(rays, args->N, k)};
    if (!walk_terrain(surfaces, ray, RTCRayN_tnear(rays, args->N, k)).hit) args->valid[k] = 0;
  }
}

}  // namespace

void attach_terrain(RTCDevice device, RTCScene tree, const TileSurfaces& surfaces, std::uint32_t geometry) {
  const bool open = geometry == TileSurfaces::kOpenTerrain;
  const TileContents& block = surfaces.contents();
  const std::size_t cells = surfaces.count(geometry) / 2;
  const std::size_t vertices = open ? (block.columns + 1) * std::size_t{block.rows + 1} + 1 : kCorners * cells;
  const GeometryOwner owner(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_QUAD));
  const Quads quads{
      static_cast<float*>(rtcSetNewGeometryBuffer(owner.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                  3 * sizeof(float), vertices)),
      static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(owner.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4,
                                                          kCorners * sizeof(std::uint32_t), cells))};
  require(quads.vertex != nullptr && quads.index != nullptr, "world.triangles", 2 * cells,
          "not enough memory for them");
  open ? fill_open_terrain(surfaces, quads)
       : fill_terrain_near_solids(surfaces, static_cast<std::uint32_t>(cells), quads);
  if (surfaces.tolerances().upward_raise_m > kHarmlessRaise_m) {
    rtcSetGeometryOccludedFilterFunction(owner.get(), &let_out_through_raised_terrain);
  }
  attach(tree, owner, geometry);
}

}  // namespace uwsim
