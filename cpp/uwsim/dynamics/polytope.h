#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "uwsim/dynamics/collision_shape.h"

namespace uwsim {

/// The corners, faces and edges of the convex hull of a set of points.
struct Polytope {
  /// The interior satisfies normal . r <= offset_m.
  struct Face {
    Eigen::Vector3d normal;
    double offset_m;
  };
  /// An edge between two faces. `into` are unit vectors in the planes of the faces, perpendicular to the edge.
  struct Edge {
    std::uint32_t from, to;
    double length_m;
    Eigen::Vector3d along;
    Eigen::Vector3d into[2];
  };

  ConvexPiece corners_m;
  std::vector<Face> faces;
  std::vector<Edge> edges;

  explicit Polytope(const ConvexPiece& points_m);
};

}  // namespace uwsim
