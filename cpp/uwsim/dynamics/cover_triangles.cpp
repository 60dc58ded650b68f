#include "uwsim/dynamics/cover_triangles.h"

#include <algorithm>
#include <cmath>

namespace uwsim {
namespace {

/// Rays meet these vertices, rounded to floats.
TriangleMesh rounded(TriangleMesh mesh) {
  for (Eigen::Vector3d& v : mesh.vertices_m) v = v.cast<float>().cast<double>();
  return mesh;
}

}  // namespace

CoverTriangles::Mesh::Mesh(const TriangleMesh& source, const CoverLayer* of)
    : mesh(rounded(source)), edges(mesh), layer(of) {
  for (const Triangle& triangle : mesh.triangles) {
    Eigen::AlignedBox3d& around = boxes.emplace_back();
    for (const std::uint32_t v : triangle) around.extend(mesh.vertices_m[v]);
    box.extend(around);
  }
}

CoverTriangles::CoverTriangles(const World& world, const CoverPlan& plan)
    : plan_(plan), tiles_(std::size_t{plan.columns()} * plan.rows(), kMostPieces) {
  for (const auto& layer : world.cover()) {
    for (const TriangleMesh& mesh : layer->meshes)
      meshes_.push_back(layer->solid ? std::make_unique<const Mesh>(mesh, layer.get()) : nullptr);
  }
}

bool CoverTriangles::lie_in(const World& world) {
  return std::ranges::any_of(world.cover(), [](const auto& layer) { return layer->solid; });
}

CoverTriangles::Tile CoverTriangles::make_tile(std::uint32_t column, std::uint32_t row) const {
  const CoverTilePlan plan = plan_.pieces(column, row, CoverPlan::Of::kSolid);
  Tile tile;
  for (const CoverPiece& piece : plan.pieces) {
    if (piece.size_m < kSmallest_m) continue;
    const Place place{piece.turn.cast<double>(), plan.middle_m + piece.at_m.cast<double>()};
    const Eigen::AlignedBox3d& box = meshes_[piece.mesh]->box;
    const Eigen::Vector3d middle = place(box.center()), half = place.turn.cwiseAbs() * (0.5 * box.sizes());
    tile.pieces.push_back({place, piece.mesh, {middle - half, middle + half}});
    tile.box.extend(tile.pieces.back().box);
  }
  return tile;
}

std::size_t CoverTriangles::find(const Eigen::Vector3d& low_world_m, const Eigen::Vector3d& high_world_m,
                                 std::size_t count, std::vector<SurfacePatch>& patches, ContactBudget& budget) const {
  visit_pieces({low_world_m, high_world_m}, [&](const Mesh& mesh, const Place& place, const auto& near) {
    if (count == patches.size()) patches.emplace_back();
    SurfacePatch& patch = patches[count];
    patch.clear();
    budget.spend(mesh.boxes.size());
    for (std::uint32_t t = 0; t < mesh.boxes.size(); ++t) {
      if (!mesh.boxes[t].intersects(near)) continue;
      budget.spend_on_triangles(1);
      mesh.edges.add_triangle(t, patch, place);
    }
    if (!patch.triangles.empty()) ++count;
  });
  return count;
}

const CoverLayer* CoverTriangles::layer_around(const Eigen::Vector3d& point_world_m) const {
  constexpr double kEnclosed = 1 - 1e-6;  // as in World::solid_around
  const CoverLayer* found = nullptr;
  visit_pieces({point_world_m, point_world_m}, [&](const Mesh& mesh, const Place&, const auto& at) {
    if (found == nullptr && std::abs(winding_number(mesh.mesh, at.min())) > kEnclosed) found = mesh.layer;
  });
  return found;
}

}  // namespace uwsim
