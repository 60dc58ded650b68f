#include "uwsim/dynamics/mesh_edges.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

namespace uwsim {
namespace {

constexpr int kTrials = 20;  // number of attempts to find a direction from which all edges of a peak point away

/// For each vertex, the first vertex at the same position.
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
  bool same_edge(const Side& other) const { return low == other.low && high == other.high; }
  bool operator<(const Side& other) const {
    return std::tie(low, high, triangle, edge) < std::tie(other.low, other.high, other.triangle, other.edge);
  }
};

Bend bend_towards(const SurfaceTriangle& triangle, std::size_t k, const Eigen::Vector3d& beyond_m) {
  const Eigen::Vector3d way = beyond_m - triangle.corners_m[k];
  const double below_m = -triangle.normal.dot(way), out_m = -triangle.into[k].dot(way);
  const double flat_m = kFlat * std::hypot(below_m, out_m);
  if (below_m < -flat_m) return Bend::kConcave;
  return below_m <= flat_m && out_m > 0 ? Bend::kFlat : Bend::kConvex;
}

/// Whether all directions lie in an open half-space, decided by the perceptron rule.
bool points_away(const std::vector<Eigen::Vector3d>& directions) {
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& d : directions) axis -= d;
  for (int trial = 0; trial < kTrials; ++trial) {
    const double size = axis.norm();
    if (size == 0) return false;
    axis /= size;
    const auto by_height = [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
      return a.dot(axis) < b.dot(axis);
    };
    const Eigen::Vector3d& highest = *std::max_element(directions.begin(), directions.end(), by_height);
    if (highest.dot(axis) < -kFlat) return true;
    axis -= (highest.dot(axis) + 2 * kFlat) * highest;
  }
  return false;
}

}  // namespace

MeshEdges::MeshEdges(const TriangleMesh& mesh) : mesh_(mesh) {
  const std::vector<std::uint32_t> first = welded(mesh.vertices_m);
  find_bends(first);
  find_peaks(first);
}

Corners MeshEdges::corners(std::uint32_t triangle) const {
  const auto& [a, b, c] = mesh_.triangles[triangle];
  return {mesh_.vertices_m[a], mesh_.vertices_m[b], mesh_.vertices_m[c]};
}

void MeshEdges::find_bends(const std::vector<std::uint32_t>& first) {
  bends_.assign(mesh_.triangles.size(), {Bend::kNone, Bend::kNone, Bend::kNone});
  beyond_.assign(mesh_.triangles.size(), {kNone, kNone, kNone});
  std::vector<Side> sides;
  sides.reserve(3 * mesh_.triangles.size());
  for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
    if (!has_area(corners(t))) continue;
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t a = first[mesh_.triangles[t][k]], b = first[mesh_.triangles[t][(k + 1) % 3]];
      sides.push_back({std::min(a, b), std::max(a, b), t, k});
    }
  }
  std::sort(sides.begin(), sides.end());
  for (std::size_t k = 0; k + 1 < sides.size(); ++k) {
    const Side &a = sides[k], &b = sides[k + 1];
    if (!a.same_edge(b)) continue;
    // Where more than two triangles share an edge, they are paired in order. Any other choice would do as well: corners
    // still touch each triangle.
    const std::uint32_t after = mesh_.triangles[b.triangle][(b.edge + 2) % 3];
    const std::uint32_t before = mesh_.triangles[a.triangle][(a.edge + 2) % 3];
    bends_[a.triangle][a.edge] = bend_towards(SurfaceTriangle(corners(a.triangle)), a.edge, mesh_.vertices_m[after]);
    bends_[b.triangle][b.edge] = bend_towards(SurfaceTriangle(corners(b.triangle)), b.edge, mesh_.vertices_m[before]);
    beyond_[a.triangle][a.edge] = after;
    ++k;
  }
}

void MeshEdges::find_peaks(const std::vector<std::uint32_t>& first) {
  std::vector<std::vector<std::uint32_t>> around(mesh_.vertices_m.size());
  std::vector<std::uint32_t> triangle_of(mesh_.vertices_m.size(), kNone);
  for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
    if (!has_area(corners(t))) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t v = first[mesh_.triangles[t][k]];
      if (triangle_of[v] == kNone) triangle_of[v] = t;
      for (const std::size_t other : {(k + 1) % 3, (k + 2) % 3}) {
        const std::uint32_t end = first[mesh_.triangles[t][other]];
        if (std::find(around[v].begin(), around[v].end(), end) == around[v].end()) around[v].push_back(end);
      }
    }
  }
  for (std::uint32_t v = 0; v < around.size(); ++v) {
    std::vector<Eigen::Vector3d> directions;
    for (const std::uint32_t end : around[v])
      directions.push_back((mesh_.vertices_m[end] - mesh_.vertices_m[v]).normalized());
    if (directions.size() >= 3 && points_away(directions)) peaks_.push_back({v, triangle_of[v], std::move(around[v])});
  }
  std::stable_sort(peaks_.begin(), peaks_.end(), [](const Peak& a, const Peak& b) { return a.triangle < b.triangle; });
}

}  // namespace uwsim
