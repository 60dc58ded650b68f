#include "uwsim/world/ray_terrain.h"

#include <embree3/rtcore.h>

#include <limits>

#include "uwsim/core/check.h"
#include "uwsim/world/ray_walk.h"

namespace uwsim {
namespace {

constexpr std::uint32_t kCorners = 4;
constexpr double kFaintRaise_m = 5e-4;  // less than shadow rays are lifted off what they start on

struct Quads {
  float* vertex;
  std::uint32_t* index;
};

void put(const Eigen::Vector3d& point, float* vertex) {
  for (int axis = 0; axis < 3; ++axis) vertex[axis] = static_cast<float>(point(axis));
}

/// The block's cells, by the block's vertices; for those that are crossed, one that is nowhere: Embree leaves them out.
void fill_plain(const TileSurfaces& surfaces, const Quads& quads) {
  const TileContents& block = surfaces.contents();
  const std::uint32_t row_length = block.columns + 1, nowhere = row_length * (block.rows + 1);
  float* vertex = quads.vertex;
  for (std::uint32_t j = 0; j <= block.rows; ++j) {
    for (std::uint32_t i = 0; i <= block.columns; ++i, vertex += 3) put(surfaces.raised_vertex_m(i, j), vertex);
  }
  put(Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()), vertex);
  std::uint32_t* index = quads.index;
  for (std::uint32_t cell = 0; cell < block.columns * block.rows; ++cell, index += kCorners) {
    const std::uint32_t corner = cell / block.columns * row_length + cell % block.columns;
    const bool crossed = surfaces.is_crossed(2 * cell);
    index[0] = crossed ? nowhere : corner;
    index[1] = crossed ? nowhere : corner + 1;
    index[2] = crossed ? nowhere : corner + row_length + 1;
    index[3] = crossed ? nowhere : corner + row_length;
  }
}

/// The crossed cells, each with corners of its own.
void fill_crossed(const TileSurfaces& surfaces, std::uint32_t cells, const Quads& quads) {
  for (std::uint32_t k = 0; k < cells; ++k) {
    const std::uint32_t cell = surfaces.plain_number(2 * k) / 2;
    const std::uint32_t i = cell % surfaces.contents().columns, j = cell / surfaces.contents().columns;
    float* vertex = quads.vertex + 3 * kCorners * k;
    put(surfaces.raised_vertex_m(i, j), vertex);
    put(surfaces.raised_vertex_m(i + 1, j), vertex + 3);
    put(surfaces.raised_vertex_m(i + 1, j + 1), vertex + 6);
    put(surfaces.raised_vertex_m(i, j + 1), vertex + 9);
  }
  for (std::uint32_t k = 0; k < kCorners * cells; ++k) quads.index[k] = k;
}

/// By a cliff the twin is high over the ground. A shadow ray that starts between the two comes out through the twin
/// from below, and is blocked only if it meets the terrain.
void leave_ground(const RTCFilterFunctionNArguments* args) {
  const TileSurfaces& surfaces = *detail_of(args->context).surfaces;
  RTCRayN* rays = args->ray;
  for (unsigned k = 0; k < args->N; ++k) {
    const Eigen::Vector3f up(RTCHitN_Ng_x(args->hit, args->N, k), RTCHitN_Ng_y(args->hit, args->N, k),
                             RTCHitN_Ng_z(args->hit, args->N, k));
    const Eigen::Vector3f way(RTCRayN_dir_x(rays, args->N, k), RTCRayN_dir_y(rays, args->N, k),
                              RTCRayN_dir_z(rays, args->N, k));
    if (args->valid[k] == 0 || up.dot(way) <= 0) continue;
    const Eigen::Vector3f origin(RTCRayN_org_x(rays, args->N, k), RTCRayN_org_y(rays, args->N, k),
                                 RTCRayN_org_z(rays, args->N, k));
    const TileRay ray{surfaces.middle_m() + origin.cast<double>(), way.cast<double>(), RTCRayN_tfar(rays, args->N, k)};
    if (!walk_terrain(surfaces, ray, RTCRayN_tnear(rays, args->N, k)).hit) args->valid[k] = 0;
  }
}

}  // namespace

void attach_terrain(RTCDevice device, RTCScene tree, const TileSurfaces& surfaces, std::uint32_t geometry) {
  const bool plain = geometry == TileSurfaces::kPlainTerrain;
  const TileContents& block = surfaces.contents();
  const std::size_t cells = surfaces.count(geometry) / 2;
  const std::size_t vertices = plain ? (block.columns + 1) * std::size_t{block.rows + 1} + 1 : kCorners * cells;
  const GeometryOwner owner(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_QUAD));
  const Quads quads{
      static_cast<float*>(rtcSetNewGeometryBuffer(owner.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                  3 * sizeof(float), vertices)),
      static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(owner.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4,
                                                          kCorners * sizeof(std::uint32_t), cells))};
  require(quads.vertex != nullptr && quads.index != nullptr, "world.triangles", 2 * cells,
          "not enough memory for them");
  plain ? fill_plain(surfaces, quads) : fill_crossed(surfaces, static_cast<std::uint32_t>(cells), quads);
  if (surfaces.highest_raise_m() > kFaintRaise_m) rtcSetGeometryOccludedFilterFunction(owner.get(), &leave_ground);
  rtcCommitGeometry(owner.get());
  rtcAttachGeometryByID(tree, owner.get(), geometry);
}

}  // namespace uwsim
