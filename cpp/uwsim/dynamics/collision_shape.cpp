#include "uwsim/dynamics/collision_shape.h"

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

ConvexPiece box_corners(const TriangleMesh& mesh) {
  Eigen::Vector3d low = mesh.vertices_m.front(), high = low;
  for (const Eigen::Vector3d& v : mesh.vertices_m) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  ConvexPiece corners;
  for (int k = 0; k < 8; ++k) {
    corners.emplace_back(k & 1 ? high.x() : low.x(), k & 2 ? high.y() : low.y(), k & 4 ? high.z() : low.z());
  }
  return corners;
}

}  // namespace

std::vector<ConvexPiece> collision_pieces(const TriangleMesh& mesh, CollisionShape shape,
                                          std::vector<ConvexPiece> pieces) {
  if (shape == CollisionShape::kBox) return {box_corners(mesh)};
  if (shape == CollisionShape::kHull) return {mesh.vertices_m};
  require(!pieces.empty(), "vehicle.collision_pieces", "none", "must be given for this shape");
  for (const ConvexPiece& piece : pieces) {
    require(piece.size() >= 4, "vehicle.collision_pieces.corners", piece.size(), "must be at least 4");
    for (const Eigen::Vector3d& corner : piece)
      require(corner.allFinite(), "vehicle.collision_pieces.corner", corner.transpose(), "must be finite");
  }
  return pieces;
}

}  // namespace uwsim
