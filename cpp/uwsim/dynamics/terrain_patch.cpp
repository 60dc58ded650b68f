#include "uwsim/dynamics/terrain_patch.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace uwsim {
namespace {

/// The terrain around a range of cells. Two triangles that share an edge form a parallelogram in plan view, so the bend
/// at the edge is the difference of the mean heights of the two diagonals.
class CellsInBox {
 public:
  CellsInBox(const Heightfield& terrain, const Eigen::Vector3d& low_m, const Eigen::Vector3d& high_m,
             SurfacePatch& patch, ContactBudget& budget)
      : terrain_(terrain),
        low_m_(low_m),
        high_m_(high_m),
        patch_(patch),
        budget_(budget),
        nx_(static_cast<std::ptrdiff_t>(terrain.nx())),
        ny_(static_cast<std::ptrdiff_t>(terrain.ny())) {
    // Heights are floats; this is the rounding error of a sum of four of them.
    const double highest = std::max(std::abs(terrain.lowest_m()), std::abs(terrain.highest_m()));
    flat_m_ = kFlat * terrain.spacing_m() + 2 * std::numeric_limits<float>::epsilon() * highest;
  }

  void add_all() {
    const auto cell = [this](double along_m, std::ptrdiff_t nodes) {
      return static_cast<std::ptrdiff_t>(
          std::clamp(std::floor(along_m / terrain_.spacing_m()), 0.0, static_cast<double>(nodes - 2)));
    };
    const Eigen::Vector2d low = low_m_.head<2>() - terrain_.origin_m(), high = high_m_.head<2>() - terrain_.origin_m();
    const std::ptrdiff_t i1 = cell(high.x(), nx_), j1 = cell(high.y(), ny_);
    for (std::ptrdiff_t j = cell(low.y(), ny_); j <= j1; ++j) {
      for (std::ptrdiff_t i = cell(low.x(), nx_); i <= i1; ++i) add_cell(i, j, i == i1, j == j1);
    }
  }

 private:
  double height(std::ptrdiff_t i, std::ptrdiff_t j) const {
    return terrain_.heights_m()[static_cast<std::size_t>(j * nx_ + i)];
  }
  Eigen::Vector3d node(std::ptrdiff_t i, std::ptrdiff_t j) const {
    return terrain_.vertex(static_cast<std::size_t>(j * nx_ + i));
  }
  bool has(std::ptrdiff_t i, std::ptrdiff_t j) const { return i >= 0 && j >= 0 && i < nx_ && j < ny_; }

  Bend bend_of(double ends_m, double others_m) const {
    const double bend_m = ends_m - others_m;
    return bend_m > flat_m_ ? Bend::kConvex : bend_m < -flat_m_ ? Bend::kConcave : Bend::kFlat;
  }
  /// The edge from node (i, j) east, north, or north-west.
  Bend east(std::ptrdiff_t i, std::ptrdiff_t j) const {
    if (!has(i, j + 1) || !has(i + 1, j - 1)) return Bend::kNone;
    return bend_of(height(i, j) + height(i + 1, j), height(i, j + 1) + height(i + 1, j - 1));
  }
  Bend north(std::ptrdiff_t i, std::ptrdiff_t j) const {
    if (!has(i + 1, j) || !has(i - 1, j + 1)) return Bend::kNone;
    return bend_of(height(i, j) + height(i, j + 1), height(i + 1, j) + height(i - 1, j + 1));
  }
  Bend north_west(std::ptrdiff_t i, std::ptrdiff_t j) const {
    return bend_of(height(i, j) + height(i - 1, j + 1), height(i - 1, j) + height(i, j + 1));
  }

  void add_cell(std::ptrdiff_t i, std::ptrdiff_t j, bool last_east, bool last_north) {
    const double highest = std::max({height(i, j), height(i + 1, j), height(i, j + 1), height(i + 1, j + 1)});
    if (highest < low_m_.z()) return;
    budget_.spend_on_triangles(2);
    SurfaceTriangle& lower = patch_.triangles.emplace_back(std::array{node(i, j), node(i + 1, j), node(i, j + 1)});
    lower.bends = {east(i, j), north_west(i + 1, j), north(i, j)};
    const Eigen::Vector3d far = node(i + 1, j + 1);
    if (lower.bends[0] == Bend::kConvex) add_edge(lower, 0, node(i + 1, j - 1));
    if (lower.bends[1] == Bend::kConvex) add_edge(lower, 1, far);
    if (lower.bends[2] == Bend::kConvex) add_edge(lower, 2, node(i - 1, j + 1));
    const Bend diagonal = lower.bends[1];
    SurfaceTriangle& upper = patch_.triangles.emplace_back(std::array{node(i + 1, j), far, node(i, j + 1)});
    upper.bends = {north(i + 1, j), east(i, j + 1), diagonal};
    // These edges and nodes belong to neighbouring cells, unless those are outside the box.
    if (upper.bends[0] == Bend::kConvex && last_east) add_edge(upper, 0, node(i + 2, j));
    if (upper.bends[1] == Bend::kConvex && last_north) add_edge(upper, 1, node(i, j + 2));
    for (std::ptrdiff_t v = 0; v <= (last_north ? 1 : 0); ++v) {
      for (std::ptrdiff_t u = 0; u <= (last_east ? 1 : 0); ++u) add_peak(i + u, j + v);
    }
  }

  void add_edge(const SurfaceTriangle& triangle, std::size_t k, const Eigen::Vector3d& beyond_m) {
    const Eigen::Vector3d &a = triangle.corners_m[k], &b = triangle.corners_m[(k + 1) % 3];
    const bool is_near =
        (a.cwiseMin(b).array() <= high_m_.array()).all() && (a.cwiseMax(b).array() >= low_m_.array()).all();
    if (is_near) patch_.edges.emplace_back(triangle, k, beyond_m);
  }

  /// Adds the node if it is above the convex hull of its six neighbours.
  void add_peak(std::ptrdiff_t i, std::ptrdiff_t j) {
    if (!has(i - 1, j - 1) || !has(i + 1, j + 1)) return;
    const double e = height(i + 1, j), n = height(i, j + 1), nw = height(i - 1, j + 1);
    const double w = height(i - 1, j), s = height(i, j - 1), se = height(i + 1, j - 1);
    const double around = std::max({(e + w) / 2, (n + s) / 2, (nw + se) / 2, (e + nw + s) / 3, (w + n + se) / 3});
    if (height(i, j) - around <= flat_m_) return;
    const Eigen::Vector3d point = node(i, j);
    if ((point.array() < low_m_.array()).any() || (point.array() > high_m_.array()).any()) return;
    patch_.peaks.push_back({point, static_cast<std::uint32_t>(patch_.neighbours_m.size()), 6});
    for (const auto& [u, v] : {std::pair{1, 0}, {0, 1}, {-1, 1}, {-1, 0}, {0, -1}, {1, -1}})
      patch_.neighbours_m.push_back(node(i + u, j + v));
  }

  const Heightfield& terrain_;
  const Eigen::Vector3d &low_m_, &high_m_;
  SurfacePatch& patch_;
  ContactBudget& budget_;
  std::ptrdiff_t nx_, ny_;
  double flat_m_;
};

}  // namespace

void add_terrain(const Heightfield& terrain, const Eigen::Vector3d& low_world_m, const Eigen::Vector3d& high_world_m,
                 SurfacePatch& patch, ContactBudget& budget) {
  CellsInBox(terrain, low_world_m, high_world_m, patch, budget).add_all();
}

}  // namespace uwsim
