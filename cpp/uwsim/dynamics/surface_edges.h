#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "uwsim/core/triangle_mesh.h"

namespace uwsim {

/// Knows each triangle's neighbours, so that a body sliding over a flat or hollow place does not stub on the edges
/// between its triangles.
class SurfaceEdges {
 public:
  /// Vertices at the same place are one. Keeps `mesh` by reference.
  explicit SurfaceEdges(const TriangleMesh& mesh);

  /// Whether a body at the tip of `normal` (unit, from the surface towards it) has `point_m` on triangle `index` as its
  /// nearest place on the surface, rather than a place on a neighbour across the edge that the point lies on.
  bool is_nearest(std::size_t index, const Eigen::Vector3d& point_m, const Eigen::Vector3d& normal) const;

 private:
  static constexpr std::uint32_t kNone = 0xffffffff;

  const TriangleMesh& mesh_;
  std::vector<Triangle> opposite_;  // the neighbour's third vertex across edge k, from vertex k to k + 1
};

}  // namespace uwsim
