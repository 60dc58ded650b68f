#pragma once

#include <Eigen/Core>
#include <vector>

#include "uwsim/core/triangle_mesh.h"

namespace uwsim {

/// Terrain as heights over a regular grid: heights_m[j * nx + i] is z at (x0 + i spacing, y0 + j spacing), world ENU.
/// Each cell is two triangles that share the diagonal from (i + 1, j) to (i, j + 1). Rays and contacts both use these
/// triangles, so they hit the same surface.
class Heightfield {
 public:
  /// Throws InvalidValue naming the terrain and the field.
  Heightfield(std::vector<float> heights_m, std::size_t nx, std::size_t ny, double spacing_m,
              const Eigen::Vector2d& origin_m);

  std::size_t nx() const { return nx_; }
  std::size_t ny() const { return ny_; }
  double spacing_m() const { return spacing_m_; }
  const Eigen::Vector2d& origin_m() const { return origin_m_; }
  Eigen::Vector2d far_corner_m() const;
  const std::vector<float>& heights_m() const { return heights_m_; }
  float lowest_m() const { return lowest_m_; }
  float highest_m() const { return highest_m_; }

  /// Height of the triangulated surface; NaN outside the grid.
  double height_at(double x_m, double y_m) const;

  /// The position of vertex j * nx + i.
  Eigen::Vector3d vertex(std::size_t index) const;
  /// Vertices of triangle `index`, 0 <= index < triangle_count(); counter-clockwise seen from above.
  Triangle triangle(std::size_t index) const;
  std::size_t triangle_count() const { return 2 * (nx_ - 1) * (ny_ - 1); }

 private:
  std::vector<float> heights_m_;
  std::size_t nx_, ny_;
  double spacing_m_;
  Eigen::Vector2d origin_m_;
  float lowest_m_, highest_m_;
};

}  // namespace uwsim
