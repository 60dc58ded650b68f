#include "uwsim/rays/tile_surfaces.h"

#include <algorithm>
#include <utility>

#include "uwsim/rays/raised_terrain.h"

namespace uwsim {
namespace {

Eigen::AlignedBox3d box_around(const RoundShape& shape) {
  const ShapeBounds limits = bounds(shape);
  return {limits.low_m, limits.high_m};
}

Eigen::AlignedBox3d box_around(const Corners& triangle) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& corner : triangle) box.extend(corner);
  return box;
}

Corners solid_corners(const Solid& solid, std::uint32_t triangle) {
  const Triangle& t = solid.mesh_world.triangles[triangle];
  const auto& v = solid.mesh_world.vertices_m;
  return {v[t[0]], v[t[1]], v[t[2]]};
}

const Solid& solid_of(const World& world, std::uint32_t label) { return *world.solids()[label - kTerrain - 1]; }

}  // namespace

TileSurfaces::TileSurfaces(const World& world, TileContents contents)
    : world_(world), contents_(std::move(contents)), share_of_geometry_(world.solids().size() + kTerrain + 1, -1) {
  for (std::size_t k = 0; k < contents_.solids.size(); ++k) {
    share_of_geometry_[contents_.solids[k].label] = static_cast<std::int32_t>(k);
  }
  whole_terrain_ = world_.terrain() && contents_.columns == world_.terrain()->nx() - 1 &&
                   contents_.rows == world_.terrain()->ny() - 1;
  measure();
  near_solids_ = find_cells_near_solids(*this);
}

/// Computes box, middle and tolerances.
void TileSurfaces::measure() {
  for (std::uint32_t j = 0; contents_.columns > 0 && j <= contents_.rows; ++j) {
    for (std::uint32_t i = 0; i <= contents_.columns; ++i) {
      box_.extend(
          world_.terrain()->vertex((contents_.first_row + j) * world_.terrain()->nx() + contents_.first_column + i));
    }
  }
  for (const TileContents::Share& share : contents_.solids) {
    for (std::uint32_t k = 0; k < share.members.size(); ++k) box_.extend(box_of({share.label, k}));
  }
  for (const TileContents::Share& share : contents_.meshes) {
    for (const std::uint32_t t : share.members)
      box_.extend(box_around(solid_corners(solid_of(world_, share.label), t)));
  }
  middle_m_ = box_.center();
  diagonal_m_ = box_.diagonal().norm();
  const auto has_triangles = [&](const TileContents::Share& share) { return !is_round(share.label); };
  tolerances_ =
      tolerances_of(diagonal_m_, steepest(world_, contents_), std::ranges::any_of(contents_.solids, has_triangles));
  box_.min().array() -= tolerances_.box_margin_m;
  box_.max().array() += tolerances_.box_margin_m;
}

const TileContents::Share& TileSurfaces::share(std::uint32_t geometry) const {
  return contents_.solids[static_cast<std::size_t>(share_of_geometry_[geometry])];
}

std::size_t TileSurfaces::count(std::uint32_t geometry) const {
  if (geometry == kTerrainNearSolids) return 2 * near_solids_.size();
  if (geometry == kOpenTerrain) return 2 * std::size_t{contents_.columns} * contents_.rows;
  return share_of_geometry_[geometry] < 0 ? 0 : share(geometry).members.size();
}

bool TileSurfaces::is_round(std::uint32_t geometry) const {
  return geometry > kTerrain && !solid_of(world_, geometry).shapes.empty();
}

std::uint32_t TileSurfaces::terrain_number(std::uint32_t block_triangle) const {
  if (whole_terrain_) return block_triangle;
  const std::uint32_t cell = block_triangle / 2;
  const auto columns = static_cast<std::uint32_t>(world_.terrain()->nx() - 1);
  const std::uint32_t row = contents_.first_row + cell / contents_.columns;
  const std::uint32_t column = contents_.first_column + cell % contents_.columns;
  return 2 * (row * columns + column) + block_triangle % 2;
}

std::uint32_t TileSurfaces::other_number(std::uint32_t geometry, std::uint32_t primitive) const {
  if (geometry == kTerrainNearSolids) return terrain_number(block_triangle(primitive));
  if (geometry == kOpenTerrain) return terrain_number(primitive);
  return share(geometry).members[primitive];
}

Corners TileSurfaces::corners(std::uint32_t geometry, std::uint32_t primitive) const {
  const std::uint32_t number = world_number(geometry, primitive);
  if (geometry > kTerrain) return solid_corners(solid_of(world_, geometry), number);
  const Triangle t = world_.terrain()->triangle(number);
  return {world_.terrain()->vertex(t[0]), world_.terrain()->vertex(t[1]), world_.terrain()->vertex(t[2])};
}

Corners TileSurfaces::mesh_corners(std::size_t mesh, std::uint32_t member) const {
  const TileContents::Share& share = contents_.meshes[mesh];
  return solid_corners(solid_of(world_, share.label), share.members[member]);
}

const RoundShape& TileSurfaces::shape(std::uint32_t geometry, std::uint32_t primitive) const {
  return solid_of(world_, geometry).shapes[world_number(geometry, primitive)];
}

Eigen::AlignedBox3d TileSurfaces::box_of(const TileMember& member) const {
  return is_round(member.geometry) ? box_around(shape(member.geometry, member.primitive))
                                   : box_around(corners(member.geometry, member.primitive));
}

std::optional<TileHit> TileSurfaces::meet(std::uint32_t geometry, std::uint32_t primitive, const TileRay& ray) const {
  if (!is_round(geometry)) return meet_triangle(corners(geometry, primitive), ray, tolerances_.edge_margin_m);
  const auto hit = first_hit(shape(geometry, primitive), ray.origin_world_m, ray.direction_world, 0, ray.far_m);
  return hit ? std::optional(TileHit{hit->distance_m, hit->normal_world, true}) : std::nullopt;
}

TerrainBlock TileSurfaces::terrain_block() const {
  const Heightfield& terrain = *world_.terrain();
  return {.heights_m = terrain.heights_m().data(),
          .origin_x = terrain.origin_m().x(),
          .origin_y = terrain.origin_m().y(),
          .cells_per_m = 1 / terrain.spacing_m(),
          .clearance_m = tolerances_.clearance_m,
          .row_length = static_cast<std::uint32_t>(terrain.nx()),
          .first_column = contents_.first_column,
          .first_row = contents_.first_row,
          .columns = contents_.columns,
          .rows = contents_.rows};
}

}  // namespace uwsim
