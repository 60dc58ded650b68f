#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "uwsim/core/triangle_mesh.h"

namespace uwsim {

/// Neighbours of each triangle of a mesh, so that a body that slides over a flat or hollow surface does not catch on
/// the edges between its triangles.
class InternalEdges {
 public:
  /// Vertices at the same place count as one. Keeps a reference to `mesh`.
  explicit InternalEdges(const TriangleMesh& mesh);

  /// Whether `point_m` on triangle `index` is the point of the surface nearest to a body in the direction `normal`
  /// (unit, from the surface towards the body), rather than a point on the neighbour across an edge that `point_m` lies
  /// on.
  bool is_nearest(std::size_t index, const Eigen::Vector3d& point_m, const Eigen::Vector3d& normal) const;

 private:
  static constexpr std::uint32_t kNone = 0xffffffff;

  const TriangleMesh& mesh_;
  std::vector<Triangle> opposite_;  // third vertex of the neighbour across edge k, which goes from vertex k to k + 1
};

}  // namespace uwsim
