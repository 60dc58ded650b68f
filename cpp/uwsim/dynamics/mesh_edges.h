#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
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
  /// Skips a triangle without area. `place`: from the mesh to where it lies, turned and scaled.
  template <typename Place = std::identity>
  void add_triangle(std::uint32_t index, SurfacePatch& patch, const Place& place = {}) const;

 private:
  static constexpr std::uint32_t kNone = 0xffffffff;

  struct Peak {
    std::uint32_t vertex, triangle;  // the first triangle that contains the vertex
    std::vector<std::uint32_t> neighbours;
  };

  static bool has_area(const Corners& corners) {
    const auto& [a, b, c] = corners;
    return (b - a).cross(c - a).squaredNorm() > 0 && b != c;
  }
  Corners corners(std::uint32_t triangle) const;
  void find_bends(const std::vector<std::uint32_t>& first);
  void find_peaks(const std::vector<std::uint32_t>& first);

  const TriangleMesh& mesh_;
  std::vector<std::array<Bend, 3>> bends_;
  // Third vertex of the triangle across edge k; kNone for edges that another triangle adds
  std::vector<Triangle> beyond_;
  std::vector<Peak> peaks_;  // ordered by the first triangle that contains them
};

template <typename Place>
void MeshEdges::add_triangle(std::uint32_t index, SurfacePatch& patch, const Place& place) const {
  const Corners own = corners(index);
  if (!has_area(own)) return;
  const Corners points{place(own[0]), place(own[1]), place(own[2])};
  SurfaceTriangle& triangle = patch.triangles.emplace_back(points);
  triangle.bends = bends_[index];
  for (std::size_t k = 0; k < 3; ++k) {
    if (triangle.bends[k] == Bend::kConvex && beyond_[index][k] != kNone)
      patch.edges.emplace_back(triangle, k, place(mesh_.vertices_m[beyond_[index][k]]));
  }
  auto peak = std::lower_bound(peaks_.begin(), peaks_.end(), index,
                               [](const Peak& a, std::uint32_t triangle_index) { return a.triangle < triangle_index; });
  for (; peak != peaks_.end() && peak->triangle == index; ++peak) {
    patch.peaks.push_back({place(mesh_.vertices_m[peak->vertex]), static_cast<std::uint32_t>(patch.neighbours_m.size()),
                           static_cast<std::uint32_t>(peak->neighbours.size())});
    for (const std::uint32_t end : peak->neighbours) patch.neighbours_m.push_back(place(mesh_.vertices_m[end]));
  }
}

}  // namespace uwsim
