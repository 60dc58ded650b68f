#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "uwsim/rays/cells_near_solids.h"
#include "uwsim/rays/ray_kernels.h"
#include "uwsim/rays/tiling.h"
#include "uwsim/rays/tolerances.h"
#include "uwsim/rays/triangle_hit.h"

namespace uwsim {

/// A tile's surfaces in double. Surfaces are identified by geometry and primitive, with the same numbers as in Embree's
/// tree.
///
/// The terrain consists of two geometries, so that the geometry that was hit reveals whether a solid is near: open
/// terrain, and cells near solids. In open terrain, triangles are numbered within the block: 2 cell and 2 cell + 1,
/// where cells are counted row by row, including cells near solids. In the other geometry, only the cells near solids
/// are counted. Solids follow, each under its label.
class TileSurfaces {
 public:
  static constexpr std::uint32_t kTerrainNearSolids = 0;
  static constexpr std::uint32_t kOpenTerrain = kTerrain;

  TileSurfaces(const World& world, TileContents contents);

  const World& world() const { return world_; }
  const TileContents& contents() const { return contents_; }
  /// Bounds of the surfaces, including the margins that the tolerances add.
  const Eigen::AlignedBox3d& box() const { return box_; }
  /// The origin of float coordinates.
  const Eigen::Vector3d& middle_m() const { return middle_m_; }
  double diagonal_m() const { return diagonal_m_; }
  const Tolerances& tolerances() const { return tolerances_; }

  std::size_t count(std::uint32_t geometry) const;
  bool is_round(std::uint32_t geometry) const;
  static bool is_terrain(std::uint32_t geometry) { return geometry <= kTerrain; }
  static Label label(std::uint32_t geometry) {
    return geometry == kTerrainNearSolids ? kTerrain : static_cast<Label>(geometry);
  }
  /// The number of a primitive within the whole terrain or solid.
  std::uint32_t world_number(std::uint32_t geometry, std::uint32_t primitive) const {
    return geometry == kOpenTerrain && whole_terrain_ ? primitive : other_number(geometry, primitive);
  }
  /// True if the tile contains all of the terrain; open terrain then has the numbers of the world.
  bool has_whole_terrain() const { return whole_terrain_; }
  Corners corners(std::uint32_t geometry, std::uint32_t primitive) const;
  Corners mesh_corners(std::size_t mesh, std::uint32_t member) const;
  const RoundShape& shape(std::uint32_t geometry, std::uint32_t primitive) const;
  /// Bounds of a triangle or shape.
  Eigen::AlignedBox3d box_of(const TileMember& member) const;
  /// The hit of a ray on one triangle, including the triangle's edges, or on one shape. The ray's limits apply only to
  /// shapes.
  std::optional<TileHit> meet(std::uint32_t geometry, std::uint32_t primitive, const TileRay& ray) const;

  /// Whether a cell of the block is near a solid; the triangles of such a cell belong only to kTerrainNearSolids.
  bool is_near_solids(std::uint32_t cell) const { return near_solids_.contains(cell); }
  /// The number, within the block, of a triangle near solids.
  std::uint32_t block_triangle(std::uint32_t triangle_near_solids) const {
    return 2 * near_solids_.cell(triangle_near_solids / 2) + triangle_near_solids % 2;
  }
  /// The solids near that triangle's cell.
  std::span<const TileMember> solids_near(std::uint32_t triangle_near_solids) const {
    return near_solids_.solids(triangle_near_solids / 2);
  }

  /// The block in the form that kernels accept.
  TerrainBlock terrain_block() const;

 private:
  const TileContents::Share& share(std::uint32_t geometry) const;
  std::uint32_t other_number(std::uint32_t geometry, std::uint32_t primitive) const;
  std::uint32_t terrain_number(std::uint32_t block_triangle) const;
  void measure();

  World world_;
  TileContents contents_;
  Eigen::AlignedBox3d box_;
  Eigen::Vector3d middle_m_;
  double diagonal_m_ = 0;
  Tolerances tolerances_{};
  bool whole_terrain_ = false;                   // whether the block is the whole terrain, with the same numbers
  std::vector<std::int32_t> share_of_geometry_;  // index into contents_.solids, -1 for none
  CellsNearSolids near_solids_;
};

}  // namespace uwsim
