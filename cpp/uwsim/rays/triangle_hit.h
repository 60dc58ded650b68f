#pragma once

#include <Eigen/Core>
#include <optional>

#include "uwsim/core/triangle_mesh.h"

namespace uwsim {

/// One ray in double precision, world frame; the direction is a unit vector.
struct TileRay {
  Eigen::Vector3d origin_world_m, direction_world;
  double far_m;
};

/// The hit of such a ray on one triangle or round shape.
struct TileHit {
  double distance_m;
  Eigen::Vector3d normal_world;  ///< unit, on the side from which the corners run counter-clockwise
  /// Whether the hit is farther inside than the tile's `edge_margin_m`, so that no neighbour can be hit
  bool clear_of_edges;
};

/// The hit of a ray's line on a triangle, including its edges (Moeller and Trumbore 1997, J. Graphics Tools 2(1)), in
/// double; the distance may be negative or beyond `far_m`. A ray in the triangle's plane misses it.
std::optional<TileHit> meet_triangle(const Corners& triangle, const TileRay& ray, double edge_margin_m);

}  // namespace uwsim
