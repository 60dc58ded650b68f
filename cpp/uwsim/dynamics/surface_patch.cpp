#include "uwsim/dynamics/surface_patch.h"

#include <Eigen/Geometry>

namespace uwsim {

SurfaceTriangle::SurfaceTriangle(const std::array<Eigen::Vector3d, 3>& corners) : corners_m(corners) {
  const auto& [a, b, c] = corners_m;
  normal = (b - a).cross(c - a).normalized();
  offset_m = normal.dot(a);
  low_m = a.cwiseMin(b).cwiseMin(c);
  high_m = a.cwiseMax(b).cwiseMax(c);
  for (std::size_t k = 0; k < 3; ++k) into[k] = normal.cross(corners_m[(k + 1) % 3] - corners_m[k]).normalized();
}

SurfaceEdge::SurfaceEdge(const SurfaceTriangle& triangle, std::size_t k, const Eigen::Vector3d& beyond_m)
    : from_m(triangle.corners_m[k]) {
  const Eigen::Vector3d way = triangle.corners_m[(k + 1) % 3] - from_m;
  length_m = way.norm();
  along = way / length_m;
  const Eigen::Vector3d out = beyond_m - from_m;
  into = {triangle.into[k], (out - along.dot(out) * along).normalized()};
  middle_normal = (triangle.normal + into[1].cross(along)).normalized();
}

void SurfacePatch::reserve(std::size_t triangles_count) {
  triangles.reserve(triangles_count);
  edges.reserve(2 * triangles_count);
  peaks.reserve(triangles_count);
  neighbours_m.reserve(6 * triangles_count);
}

void SurfacePatch::clear() {
  triangles.clear();
  edges.clear();
  peaks.clear();
  neighbours_m.clear();
}

}  // namespace uwsim
