#include "uwsim/dynamics/internal_edges.h"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace uwsim {
namespace {

constexpr double kOnEdge = 1e-3;  // distance from an edge, relative to the triangle's height over it
constexpr double kFlat = 1e-3;    // sine of the angle by which a flat surface may bend

/// For each vertex, the first one at the same place.
std::vector<std::uint32_t> welded(const std::vector<Eigen::Vector3d>& vertices_m) {
  std::vector<std::uint32_t> order(vertices_m.size()), first(vertices_m.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto before = [&](std::uint32_t a, std::uint32_t b) {
    const Eigen::Vector3d &u = vertices_m[a], &v = vertices_m[b];
    return std::lexicographical_compare(u.data(), u.data() + 3, v.data(), v.data() + 3);
  };
  std::stable_sort(order.begin(), order.end(), before);
  for (std::size_t k = 0; k < order.size(); ++k) {
    const bool repeats = k > 0 && vertices_m[order[k]] == vertices_m[order[k - 1]];
    first[order[k]] = repeats ? first[order[k - 1]] : order[k];
  }
  return first;
}

struct Side {
  std::uint32_t low, high;  // ends of the edge, as welded vertices
  std::uint32_t triangle, edge;
  bool operator<(const Side& other) const {
    return std::tie(low, high, triangle, edge) < std::tie(other.low, other.high, other.triangle, other.edge);
  }
};

}  // namespace

InternalEdges::InternalEdges(const TriangleMesh& mesh)
    : mesh_(mesh), opposite_(mesh.triangles.size(), Triangle{kNone, kNone, kNone}) {
  const std::vector<std::uint32_t> first = welded(mesh.vertices_m);
  std::vector<Side> sides;
  sides.reserve(3 * mesh.triangles.size());
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t a = first[mesh.triangles[t][k]], b = first[mesh.triangles[t][(k + 1) % 3]];
      sides.push_back({std::min(a, b), std::max(a, b), t, k});
    }
  }
  std::sort(sides.begin(), sides.end());
  for (std::size_t k = 0; k + 1 < sides.size(); ++k) {
    const Side &a = sides[k], &b = sides[k + 1];
    if (a.low != b.low || a.high != b.high) continue;
    opposite_[a.triangle][a.edge] = mesh.triangles[b.triangle][(b.edge + 2) % 3];
    opposite_[b.triangle][b.edge] = mesh.triangles[a.triangle][(a.edge + 2) % 3];
  }
}

bool InternalEdges::is_nearest(std::size_t index, const Eigen::Vector3d& point_m, const Eigen::Vector3d& normal) const {
  for (std::size_t k = 0; k < 3; ++k) {
    if (opposite_[index][k] == kNone) continue;
    const Triangle& t = mesh_.triangles[index];
    const Eigen::Vector3d& a = mesh_.vertices_m[t[k]];
    const Eigen::Vector3d along = (mesh_.vertices_m[t[(k + 1) % 3]] - a).normalized();
    const auto from_edge = [&](const Eigen::Vector3d& p) -> Eigen::Vector3d {
      return (p - a) - along * along.dot(p - a);
    };
    if (from_edge(point_m).norm() > kOnEdge * from_edge(mesh_.vertices_m[t[(k + 2) % 3]]).norm()) continue;
    const Eigen::Vector3d beyond = from_edge(mesh_.vertices_m[opposite_[index][k]]).normalized();
    if (normal.dot(beyond) > kFlat) return false;
  }
  return true;
}

}  // namespace uwsim
