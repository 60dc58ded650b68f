#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "uwsim/world/ray_kernels.h"
#include "uwsim/world/world.h"

namespace uwsim {

/// What of the world a tile holds: a block of the terrain's cells, and of each solid what rays meet (its triangles, or
/// its round shapes) and, where that is shapes, the triangles of its mesh too.
struct TileContents {
  struct Share {
    Label label;
    std::vector<std::uint32_t> members;
  };
  std::uint32_t first_column = 0, first_row = 0, columns = 0, rows = 0;
  std::vector<Share> solids;
  std::vector<Share> meshes;
};

/// A ray that is followed through a tile, in double.
struct TileRay {
  Eigen::Vector3d origin_world_m, direction_world;
  double far_m;
};

struct TileHit {
  double distance_m;
  Eigen::Vector3d normal_world;
  bool clear_of_edges;  ///< by more than the tile's `reach_m`
};

inline constexpr double kSeam = 1e-10;  ///< barycentric: what double leaves open between neighbours

using Corners = std::array<Eigen::Vector3d, 3>;

/// A tile's surfaces in double, numbered as the ray tree numbers them: by geometry, then by primitive.
class TileSurfaces {
 public:
  /// The terrain's cells that a solid comes near, apart from the rest: there, either may be hit first.
  static constexpr std::uint32_t kCrossedTerrain = 0;
  static constexpr std::uint32_t kPlainTerrain = kTerrain;  // solids follow, each by its label

  TileSurfaces(const World& world, TileContents contents);

  const World& world() const { return world_; }
  const TileContents& contents() const { return contents_; }
  const Eigen::AlignedBox3d& box() const { return box_; }
  const Eigen::Vector3d& middle_m() const { return middle_m_; }
  double diagonal_m() const { return diagonal_m_; }
  /// More than any point of a ray or surface in this tile moves when rounded to float about the middle.
  double reach_m() const { return reach_m_; }
  /// By how much triangles are widened for the ray tree. A ray's error grows along a surface as it grazes it, 570 times
  /// at 0.1 degree; and that error is a small part of the reach.
  double rim_m() const { return kRim * reach_m_; }
  /// How far from where Embree names it, across the ray, a true hit may be.
  double error_m() const { return kError * reach_m_; }
  /// So far before their start, rays in double are cast in float where solids have triangles: else float's error hides
  /// one just before them, which they come to at 0.1 degree or more.
  double back_m() const { return back_m_; }
  /// How far off the terrain its twin in the ray tree is, measured across.
  double raise_m() const { return kRaise * reach_m_; }
  /// Where that has a vertex of the block (column and row), about the middle: higher, by so much as takes it off the
  /// steepest triangle there; at the block's edges wider too.
  Eigen::Vector3d raised_vertex_m(std::uint32_t column, std::uint32_t row) const;
  /// How far over the terrain the twin is, at its steepest.
  double highest_raise_m() const { return raise_m() * steepest_; }
  /// A ray that is so high above the terrain is above its twin, too.
  double clearance_m() const { return 4 * highest_raise_m(); }

  std::size_t count(std::uint32_t geometry) const;
  bool is_round(std::uint32_t geometry) const;
  static Label label(std::uint32_t geometry) {
    return geometry == kCrossedTerrain ? kTerrain : static_cast<Label>(geometry);
  }
  /// The number within the whole terrain or solid.
  std::uint32_t world_number(std::uint32_t geometry, std::uint32_t primitive) const {
    return geometry == kPlainTerrain && whole_terrain_ ? primitive : other_number(geometry, primitive);
  }
  Corners corners(std::uint32_t geometry, std::uint32_t primitive) const;
  Corners mesh_corners(std::size_t mesh, std::uint32_t member) const;
  const RoundShape& shape(std::uint32_t geometry, std::uint32_t primitive) const;
  /// A plain terrain triangle's cell is crossed, so that it counts under kCrossedTerrain only.
  bool is_crossed(std::uint32_t plain_triangle) const { return is_crossed_[plain_triangle / 2] != 0; }
  /// The plain number of a crossed triangle, and what comes near its cell.
  std::uint32_t plain_number(std::uint32_t crossed_triangle) const {
    return 2 * crossings_[crossed_triangle / 2].cell + crossed_triangle % 2;
  }
  struct Member {
    std::uint32_t geometry, primitive;
  };
  std::span<const Member> company(std::uint32_t crossed_triangle) const {
    const Crossing& crossing = crossings_[crossed_triangle / 2];
    return std::span(company_).subspan(crossing.first, crossing.count);
  }
  /// Where a ray meets one triangle or shape, its edges included.
  std::optional<TileHit> meet(std::uint32_t geometry, std::uint32_t primitive, const TileRay& ray) const;

  TerrainBlock terrain_block() const;

 private:
  static constexpr double kRim = 64, kError = 8, kRaise = 0.5, kBack = 256;

  const TileContents::Share& share(std::uint32_t geometry) const;
  std::uint32_t other_number(std::uint32_t geometry, std::uint32_t primitive) const;
  std::uint32_t terrain_number(std::uint32_t plain_triangle) const;
  void measure();
  double steepness(std::uint32_t column, std::uint32_t row, int side) const;
  double steepest_at(std::uint32_t column, std::uint32_t row) const;
  void find_crossings();
  void add_cells_near(const Member& member, std::vector<std::pair<std::uint32_t, Member>>& found) const;

  /// A cell of the block that something comes near, and where in `company_` that is listed.
  struct Crossing {
    std::uint32_t cell, first, count;
  };

  World world_;
  TileContents contents_;
  Eigen::AlignedBox3d box_;
  Eigen::Vector3d middle_m_;
  double diagonal_m_ = 0, reach_m_ = 0;
  double back_m_ = 0;
  double steepest_ = 1;                   // of the terrain's triangles, see steepness()
  bool whole_terrain_ = false;            // its numbers are the world's
  std::vector<std::uint8_t> is_crossed_;  // by cell of the block
  std::vector<Crossing> crossings_;
  std::vector<Member> company_;
  std::vector<std::int32_t> share_of_geometry_;  // into contents_.solids, -1 for none
};

/// Where a ray meets a triangle, edges included (Moeller and Trumbore 1997, J. Graphics Tools 2(1)), in double.
std::optional<TileHit> meet_triangle(const Corners& triangle, const TileRay& ray, double reach_m);

/// Closest point on a triangle (Ericson 2005, "Real-Time Collision Detection", 5.1.5); edges may have no length.
Eigen::Vector3d closest_on_triangle(const Eigen::Vector3d& p, const Corners& triangle);

/// The triangle with each edge moved outward in its plane by `rim_m`, or by more where a corner is sharper than 14
/// degrees.
Corners widened(const Corners& triangle, double rim_m);

}  // namespace uwsim
