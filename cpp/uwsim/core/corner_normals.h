#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "uwsim/core/triangle_mesh.h"

namespace uwsim {

/// A place on the smooth surface for which a mesh's facets stand.
struct SmoothPlace {
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  ///< unit, on the winding side
  float rise_m = 0;                                  ///< of the smooth surface above the facet, at least 0
};

/// The normals at the corners of a mesh's triangles: the mean over the triangles around a vertex, weighted by their
/// angles there (Thuermer and Wuethrich 1998, J. Graphics Tools 3(1)). Triangles that meet at more than kCrease_rad
/// are divided by an edge, which stays sharp. Vertices at the same place are one.
class CornerNormals {
 public:
  static constexpr double kCrease_rad = 0.8;  ///< 46 degrees: a ball of 80 triangles is round, a box is not

  explicit CornerNormals(const TriangleMesh& mesh);

  /// False if the surface is flat on each triangle, so that there is nothing to smooth.
  bool bend() const { return bend_; }
  /// The place with barycentric coordinates u and v of a triangle's second and third corner; the triangle's corners are
  /// in the units in which the rise is wanted. The rise is that of tangent planes through the corners (Hanika 2021,
  /// "Hacking the shadow terminator", Ray Tracing Gems II).
  SmoothPlace at(std::uint32_t triangle, float u, float v, const std::array<Eigen::Vector3f, 3>& corners) const;

 private:
  bool bend_ = false;
  std::vector<std::array<Eigen::Vector3f, 3>> normals_;
};

}  // namespace uwsim
