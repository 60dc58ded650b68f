#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <vector>

#include "uwsim/core/kept_tiles.h"
#include "uwsim/dynamics/contact_budget.h"
#include "uwsim/dynamics/mesh_edges.h"
#include "uwsim/dynamics/surface_patch.h"
#include "uwsim/world/cover_plan.h"

namespace uwsim {

/// The triangles of the solid layers' pieces, for contacts: the same pieces that rays meet, made tile by tile where a
/// body comes near. Smaller pieces than kSmallest_m are left out: the bed stands for them. Thread-safe.
class CoverTriangles {
 public:
  static constexpr double kSmallest_m = 0.05;
  /// The pieces in memory, at about 0.1 kB each, above which tiles are released.
  static constexpr std::size_t kMostPieces = 200'000;

  /// Keeps references to `plan`, the plan of this world, and to the layers.
  CoverTriangles(const World& world, const CoverPlan& plan);

  /// True if a layer of the world is solid.
  static bool lie_in(const World& world);
  /// How far a piece extends at most from its origin, which lies on the bed.
  double reach_m() const { return plan_.reach_m(CoverPlan::Of::kSolid); }

  /// Writes a patch for each piece with triangles near the box, after the first `count` patches, and returns the new
  /// number of patches. `patches` only grows, so its memory is reused. Throws ContactBudgetExceeded.
  std::size_t find(const Eigen::Vector3d& low_world_m, const Eigen::Vector3d& high_world_m, std::size_t count,
                   std::vector<SurfacePatch>& patches, ContactBudget& budget) const;
  /// The layer of a piece that encloses the point, or null; an open piece encloses nothing.
  const CoverLayer* layer_around(const Eigen::Vector3d& point_world_m) const;
  /// Calls visit(corners) for each triangle near the box.
  template <typename Visit>
  void visit(const Eigen::Vector3d& low_world_m, const Eigen::Vector3d& high_world_m, const Visit& visit) const {
    visit_pieces({low_world_m, high_world_m}, [&](const Mesh& mesh, const Place& place, const auto& near) {
      for (std::uint32_t t = 0; t < mesh.boxes.size(); ++t) {
        const Triangle& triangle = mesh.mesh.triangles[t];
        const auto& at = mesh.mesh.vertices_m;
        if (mesh.boxes[t].intersects(near))
          visit(Corners{place(at[triangle[0]]), place(at[triangle[1]]), place(at[triangle[2]])});
      }
    });
  }

 private:
  struct Mesh {
    TriangleMesh mesh;
    MeshEdges edges;  // of that mesh
    std::vector<Eigen::AlignedBox3d> boxes;
    Eigen::AlignedBox3d box;
    const CoverLayer* layer;

    Mesh(const TriangleMesh& source, const CoverLayer* of);
  };
  /// From a mesh's frame to the world's.
  struct Place {
    Eigen::Matrix3d turn;
    Eigen::Vector3d at_m;
    Eigen::Vector3d operator()(const Eigen::Vector3d& point) const { return at_m + turn * point; }
  };
  struct Piece {
    Place place;
    std::uint32_t mesh;
    Eigen::AlignedBox3d box;
  };
  struct Tile {
    Eigen::AlignedBox3d box;
    std::vector<Piece> pieces;
    std::size_t items() const { return pieces.size() + 1; }
  };

  Tile make_tile(std::uint32_t column, std::uint32_t row) const;

  /// Calls visit(mesh, place, near) for each piece whose box meets another, `near` in the mesh's frame.
  template <typename Visit>
  void visit_pieces(const Eigen::AlignedBox3d& box, const Visit& visit) const {
    if (!box.min().allFinite() || !box.max().allFinite()) return;
    const auto [left, right, low, high] = plan_.tiles_near(box.min().head<2>(), box.max().head<2>(), reach_m());
    const KeptTiles<Tile>::InUse in_use(tiles_);
    for (std::int64_t row = low; row <= high; ++row) {
      for (std::int64_t column = left; column <= right; ++column) {
        const auto i = static_cast<std::uint32_t>(column), j = static_cast<std::uint32_t>(row);
        const Tile& tile = tiles_.get(std::size_t{j} * plan_.columns() + i, [&] { return make_tile(i, j); });
        if (!tile.box.intersects(box)) continue;
        for (const Piece& piece : tile.pieces) {
          if (!piece.box.intersects(box)) continue;
          const Eigen::Matrix3d back = piece.place.turn.inverse();
          const Eigen::Vector3d middle = back * (box.center() - piece.place.at_m);
          const Eigen::Vector3d half = back.cwiseAbs() * (0.5 * box.sizes());
          visit(*meshes_[piece.mesh], piece.place, Eigen::AlignedBox3d(middle - half, middle + half));
        }
      }
    }
  }

  const CoverPlan& plan_;
  std::vector<std::unique_ptr<const Mesh>> meshes_;
  KeptTiles<Tile> tiles_;
};

}  // namespace uwsim
