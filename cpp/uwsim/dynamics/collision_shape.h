#pragma once

#include <Eigen/Core>
#include <vector>

#include "uwsim/core/triangle_mesh.h"
#include "uwsim/world/round_shape.h"

namespace uwsim {

/// A body's collision shape: the convex hull of its mesh, its bounding box along the body axes, or convex pieces that
/// follow its concavities.
enum class CollisionShape { kHull, kBox, kPieces };

/// The corners of a convex piece of a body, body frame [m].
using ConvexPiece = std::vector<Eigen::Vector3d>;

/// A ball, a rod with round ends (a ball swept along its axis) or a drum with flat ends, body frame.
struct RoundPiece {
  Eigen::Vector3d middle_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d half_axis_m = Eigen::Vector3d::Zero();  ///< from the middle to the centre of an end; zero for a ball
  double radius_m = 0;
  bool has_flat_ends = false;

  bool operator==(const RoundPiece& other) const {
    return middle_m == other.middle_m && half_axis_m == other.half_axis_m && radius_m == other.radius_m &&
           has_flat_ends == other.has_flat_ends;
  }
  /// The half edges of its bounding box along the axes.
  Eigen::Vector3d half_size_m() const;
  /// Throws InvalidValue unless all is finite, the radius is positive, and flat ends have a distance.
  void check() const;
};

/// A ball or a drum, body frame.
RoundPiece round_piece(const RoundShape& shape_body);

/// Returns the convex pieces of a shape: one for kHull and kBox, `pieces` for kPieces. Throws InvalidValue if `pieces`
/// are needed but missing, or not finite.
std::vector<ConvexPiece> collision_pieces(const TriangleMesh& mesh, CollisionShape shape,
                                          std::vector<ConvexPiece> pieces);

}  // namespace uwsim
