#pragma once

#include <Eigen/Core>
#include <vector>

#include "uwsim/core/triangle_mesh.h"

namespace uwsim {

/// The shape of a body in collisions: the convex hull of its mesh, its bounding box along the body's axes, or convex
/// pieces that follow its concavities.
enum class CollisionShape { kHull, kBox, kPieces };

/// Corners of a convex piece of a body, body frame [m].
using ConvexPiece = std::vector<Eigen::Vector3d>;

/// The convex pieces of a shape: one for kHull and kBox, and `pieces` for kPieces. Throws InvalidValue if these are
/// missing or not finite.
std::vector<ConvexPiece> collision_pieces(const TriangleMesh& mesh, CollisionShape shape,
                                          std::vector<ConvexPiece> pieces);

}  // namespace uwsim
