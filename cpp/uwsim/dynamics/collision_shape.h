#pragma once

#include <Eigen/Core>
#include <vector>

#include "uwsim/core/triangle_mesh.h"

namespace uwsim {

/// What a body collides as: its mesh's convex hull, the box along the body's axes round the mesh, or convex pieces that
/// follow its hollows.
enum class CollisionShape { kHull, kBox, kPieces };

/// Corners of a convex piece of a body, body frame [m].
using ConvexPiece = std::vector<Eigen::Vector3d>;

/// The pieces that a hull or a box is: one. `pieces` are given back for kPieces. Throws InvalidValue when they are none
/// or not finite.
std::vector<ConvexPiece> collision_pieces(const TriangleMesh& mesh, CollisionShape shape,
                                          std::vector<ConvexPiece> pieces);

}  // namespace uwsim
