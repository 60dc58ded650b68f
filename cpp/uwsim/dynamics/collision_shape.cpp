#include "uwsim/dynamics/collision_shape.h"

#include <cmath>

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

Eigen::Vector3d RoundPiece::half_size_m() const {
  const Eigen::Array3d out = half_axis_m.array().abs();
  if (!has_flat_ends) return out + radius_m;
  const Eigen::Array3d along = half_axis_m.normalized().array();
  return out + radius_m * (1 - along.square()).max(0).sqrt();
}

void RoundPiece::check() const {
  require(middle_m.allFinite() && half_axis_m.allFinite(), "round.axis", half_axis_m.transpose(), "must be finite");
  require(std::isfinite(radius_m) && radius_m > 0, "round.radius_m", radius_m, "must be positive");
  require(!has_flat_ends || half_axis_m.norm() > 0, "round.half_axis_m", 0, "must be positive for flat ends");
}

RoundPiece round_piece(const RoundShape& shape_body) {
  const auto& [from, to] = shape_body.ends;
  return {.middle_m = 0.5 * (from.point_world_m + to.point_world_m),
          .half_axis_m = 0.5 * (to.point_world_m - from.point_world_m),
          .radius_m = shape_body.radius_m,
          .has_flat_ends = !shape_body.is_sphere()};
}

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
