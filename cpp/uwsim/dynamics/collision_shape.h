#pragma once

#include <Eigen/Core>
#include <vector>

#include "uwsim/core/triangle_mesh.h"

namespace uwsim {

/// A body's collision shape: the convex hull of its mesh, its bounding box along the body axes, or convex pieces that
/// follow its concavities.
enum class CollisionShape { kHull, kBox, kPieces };

/// The corners of a convex piece of a body, body frame [m].
using ConvexPiece = std::vector<Eigen::Vector3d>;

/// Returns the convex pieces of a shape: one for kHull and kBox, `pieces` for kPieces. Throws InvalidValue if `pieces`
/// are needed but missing, or not finite.
std::vector<ConvexPiece> collision_pieces(const TriangleMesh& mesh, CollisionShape shape,
                                          std::vector<ConvexPiece> pieces);

}  // namespace uwsim
