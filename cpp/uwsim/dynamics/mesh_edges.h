#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "uwsim/core/triangle_mesh.h"
#include "uwsim/dynamics/surface_patch.h"

namespace uwsim {

/// Classifies the edges of a mesh by how the surface bends there, and finds its peaks. Vertices at the same position
/// count as one.
class MeshEdges {
 public:
  /// Keeps a reference to `mesh`.
  explicit MeshEdges(const TriangleMesh& mesh);

  /// Adds triangle `index` to `patch`, along with its edges and peaks that belong to no earlier triangle of the mesh.
  /// Skips a triangle without area.
  void add_triangle(std::uint32_t index, SurfacePatch& patch) const;

 private:
  static constexpr std::uint32_t kNone = 0xffffffff;

  struct Peak {
    std::uint32_t vertex, triangle;  // the first triangle that contains the vertex
    std::vector<std::uint32_t> neighbours;
  };

  std::array<Eigen::Vector3d, 3> corners(std::uint32_t triangle) const;
  void find_bends(const std::vector<std::uint32_t>& first);
  void find_peaks(const std::vector<std::uint32_t>& first);

  const TriangleMesh& mesh_;
  std::vector<std::array<Bend, 3>> bends_;
  // Third vertex of the triangle across edge k; kNone for edges that another triangle adds
  std::vector<Triangle> beyond_;
  std::vector<Peak> peaks_;  // ordered by the first triangle that contains them
};

}  // namespace uwsim
