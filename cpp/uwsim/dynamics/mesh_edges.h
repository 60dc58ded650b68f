#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "uwsim/core/triangle_mesh.h"
#include "uwsim/dynamics/surface_patch.h"

namespace uwsim {

/// How a mesh bends at the edges of its triangles, and where it has peaks. Vertices at the same place count as one.
class MeshEdges {
 public:
  /// Keeps a reference to `mesh`.
  explicit MeshEdges(const TriangleMesh& mesh);

  /// Adds triangle `index` to `patch`, with those of its edges and peaks that no earlier triangle of the mesh has.
  /// Skips a triangle without area.
  void add_triangle(std::uint32_t index, SurfacePatch& patch) const;

 private:
  static constexpr std::uint32_t kNone = 0xffffffff;

  struct Peak {
    std::uint32_t vertex, triangle;  // the first triangle that has it
    std::vector<std::uint32_t> neighbours;
  };

  std::array<Eigen::Vector3d, 3> corners(std::uint32_t triangle) const;
  void find_bends(const std::vector<std::uint32_t>& first);
  void find_peaks(const std::vector<std::uint32_t>& first);

  const TriangleMesh& mesh_;
  std::vector<std::array<Bend, 3>> bends_;
  // third vertex of the triangle across edge k; kNone for edges that another triangle adds
  std::vector<Triangle> beyond_;
  std::vector<Peak> peaks_;  // in the order of the first triangles that have them
};

}  // namespace uwsim
