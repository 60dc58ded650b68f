#include "uwsim/vehicle/panels.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <queue>
#include <unordered_map>
#include <utility>
#include <vector>

namespace uwsim {
namespace {

constexpr double kSharp = 0.87;  // the cosine of the angle between normals, 30 degrees, from which an edge is sharp
constexpr double kReach = 0.3;   // how far a sharp edge matters, relative to the square root of the hull's area
constexpr double kFlat = 1e-9;   // triangles are in one plane if their tips are closer to it, relative to their sides

using Edge = std::pair<std::uint32_t, std::uint32_t>;  // from the smaller index to the greater

Edge edge_of(std::uint32_t a, std::uint32_t b) { return std::minmax(a, b); }

class Refinement {
 public:
  explicit Refinement(const TriangleMesh& mesh) : mesh_(mesh) {
    double area_m2 = 0;
    for (std::uint32_t i = 0; i < mesh_.triangles.size(); ++i) {
      area_m2 += 0.5 * doubled_area(i).norm();
      for (int k = 0; k < 3; ++k) triangles_of_[side(i, k)].push_back(i);
    }
    reach_m_ = kReach * std::sqrt(area_m2);
    std::vector<Edge> edges;
    for (std::uint32_t i = 0; i < mesh_.triangles.size(); ++i) {
      for (int k = 0; k < 3; ++k) {
        const auto& own = triangles_of_.at(side(i, k));
        if (own.front() != i) continue;
        edges.push_back(side(i, k));
        if (is_sharp(edges.back(), own)) sharp_.emplace_back(at(edges.back().first), at(edges.back().second));
      }
    }
    for (std::uint32_t k = 0; k < mesh_.vertices_m.size(); ++k) to_sharp_m_.push_back(to_sharp_m(at(k)));
    for (const Edge& edge : edges) waiting_.emplace(stretched_m(edge), edge);
    flip_around(std::move(edges));
  }

  TriangleMesh to(std::size_t panels) && {
    while (mesh_.triangles.size() < panels) {
      const Edge edge = waiting_.top().second;
      waiting_.pop();
      if (triangles_of_.contains(edge)) split(edge);
    }
    return std::move(mesh_);
  }

 private:
  struct Hash {
    std::size_t operator()(const Edge& e) const { return (std::size_t{e.first} << 32 | e.second) * 0x9e3779b97f4a7c15; }
  };

  const Eigen::Vector3d& at(std::uint32_t vertex) const { return mesh_.vertices_m[vertex]; }

  Edge side(std::uint32_t triangle, int k) const {
    return edge_of(mesh_.triangles[triangle][k], mesh_.triangles[triangle][(k + 1) % 3]);
  }

  Eigen::Vector3d doubled_area(std::uint32_t triangle) const {
    const auto& [a, b, c] = mesh_.triangles[triangle];
    return (at(b) - at(a)).cross(at(c) - at(a));
  }

  std::uint32_t tip(std::uint32_t triangle, const Edge& edge) const {
    const auto& [a, b, c] = mesh_.triangles[triangle];
    return a ^ b ^ c ^ edge.first ^ edge.second;
  }

  bool is_sharp(const Edge& edge, const std::vector<std::uint32_t>& own) const {
    if (own.size() != 2) return true;  // parts touch
    const Eigen::Vector3d first = doubled_area(own[0]).normalized(), second = doubled_area(own[1]).normalized();
    return first.dot(second) < kSharp && first.dot(at(tip(own[1], edge)) - at(edge.first)) < 0;
  }

  double to_sharp_m(const Eigen::Vector3d& point_m) const {
    double least_m2 = reach_m_ * reach_m_;
    for (const auto& [from, to] : sharp_) {
      const Eigen::Vector3d along = to - from;
      const double share = std::clamp((point_m - from).dot(along) / along.squaredNorm(), 0.0, 1.0);
      least_m2 = std::min(least_m2, (from + share * along - point_m).squaredNorm());
    }
    return std::sqrt(least_m2);
  }

  /// A coordinate across sharp edges in which layers of equal thickness suit the flow.
  double stretched_m(double to_sharp_m) const { return reach_m_ * std::cbrt(to_sharp_m / reach_m_); }

  double stretched_m(const Edge& edge) const {
    const double first = stretched_m(to_sharp_m_[edge.first]), second = stretched_m(to_sharp_m_[edge.second]);
    const double middle = stretched_m(to_sharp_m(0.5 * (at(edge.first) + at(edge.second))));
    return std::hypot((at(edge.second) - at(edge.first)).norm(), std::abs(first - middle) + std::abs(second - middle));
  }

  /// Returns the share of an edge at which to split it: between its middle and, if it leads away from a sharp edge,
  /// that in the stretched coordinate.
  double cut(const Edge& edge) const {
    const double first_m = to_sharp_m_[edge.first], second_m = to_sharp_m_[edge.second], rise_m = second_m - first_m;
    if (std::abs(rise_m) < 1e-6 * reach_m_) return 0.5;
    const double first = stretched_m(first_m), second = stretched_m(second_m);
    const double middle_m = std::pow(0.5 * (first + second) / reach_m_, 3) * reach_m_;
    const double across_m2 = (second - first) * (second - first);
    const double along_m2 = std::max(0.0, (at(edge.second) - at(edge.first)).squaredNorm() - rise_m * rise_m);
    return (0.5 * along_m2 + (middle_m - first_m) / rise_m * across_m2) / (along_m2 + across_m2);
  }

  void split(const Edge& edge) {
    const std::vector<std::uint32_t> own = std::move(triangles_of_.extract(edge).mapped());
    const auto middle = static_cast<std::uint32_t>(mesh_.vertices_m.size());
    mesh_.vertices_m.push_back(at(edge.first) + cut(edge) * (at(edge.second) - at(edge.first)));
    to_sharp_m_.push_back(to_sharp_m(mesh_.vertices_m.back()));
    std::vector<Edge> around, fresh{edge_of(edge.first, middle), edge_of(edge.second, middle)};
    for (const std::uint32_t triangle : own) {
      Triangle t = mesh_.triangles[triangle];
      while (edge_of(t[0], t[1]) != edge) std::rotate(t.begin(), t.begin() + 1, t.end());
      const auto added = static_cast<std::uint32_t>(mesh_.triangles.size());
      mesh_.triangles[triangle] = {t[0], middle, t[2]};
      mesh_.triangles.push_back({middle, t[1], t[2]});
      auto& moved = triangles_of_[edge_of(t[1], t[2])];
      std::replace(moved.begin(), moved.end(), triangle, added);
      triangles_of_[edge_of(t[0], middle)].push_back(triangle);
      triangles_of_[edge_of(middle, t[1])].push_back(added);
      triangles_of_[edge_of(middle, t[2])] = {triangle, added};
      fresh.push_back(edge_of(middle, t[2]));
      around.push_back(edge_of(t[1], t[2]));
      around.push_back(edge_of(t[2], t[0]));
    }
    for (const Edge& each : fresh) waiting_.emplace(stretched_m(each), each);
    flip_around(std::move(around));
  }

  /// Replaces edges within a plane by the other diagonal where that is shorter, so that triangles are not slender.
  void flip_around(std::vector<Edge> edges) {
    while (!edges.empty()) {
      const Edge edge = edges.back();
      edges.pop_back();
      const auto found = triangles_of_.find(edge);
      if (found == triangles_of_.end() || found->second.size() != 2) continue;
      const std::uint32_t first = found->second[0], second = found->second[1];
      const std::uint32_t to = tip(second, edge);
      Triangle t = mesh_.triangles[first];
      while (edge_of(t[0], t[1]) != edge) std::rotate(t.begin(), t.begin() + 1, t.end());
      const Edge other = edge_of(t[2], to);
      if (triangles_of_.contains(other) || !is_flat(t, to)) continue;
      const double length_m = stretched_m(other);
      if (length_m > 0.999 * stretched_m(edge)) continue;
      triangles_of_.erase(found);
      mesh_.triangles[first] = {t[0], to, t[2]};
      mesh_.triangles[second] = {to, t[1], t[2]};
      auto& one = triangles_of_[edge_of(t[1], t[2])];
      std::replace(one.begin(), one.end(), first, second);
      auto& two = triangles_of_[edge_of(t[0], to)];
      std::replace(two.begin(), two.end(), second, first);
      triangles_of_[other] = {first, second};
      waiting_.emplace(length_m, other);
      for (int k = 0; k < 3; ++k) edges.push_back(edge_of(t[k], t[(k + 1) % 3]));
      edges.insert(edges.end(), {edge_of(t[0], to), edge_of(t[1], to)});
    }
  }

  /// Returns true if a triangle and the one beyond its first edge lie in a plane and make a convex quadrangle.
  bool is_flat(const Triangle& t, std::uint32_t to) const {
    const Eigen::Vector3d a = at(t[0]), b = at(t[1]), c = at(t[2]), d = at(to);
    const Eigen::Vector3d normal = (b - a).cross(c - a).normalized();
    const double side_m = (c - d).norm() + (b - a).norm();
    if (std::abs(normal.dot(d - a)) > kFlat * side_m) return false;
    const double least_m2 = kFlat * side_m * side_m;
    return normal.dot((d - a).cross(c - a)) > least_m2 && normal.dot((b - d).cross(c - d)) > least_m2;
  }

  TriangleMesh mesh_;
  std::unordered_map<Edge, std::vector<std::uint32_t>, Hash> triangles_of_;
  std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> sharp_;
  std::vector<double> to_sharp_m_;  // of each vertex, at most reach_m_
  double reach_m_ = 0;
  std::priority_queue<std::pair<double, Edge>> waiting_;  // edges by their length, with some that are gone
};

}  // namespace

TriangleMesh refined(const TriangleMesh& mesh, std::size_t panels) {
  require_closed(mesh, "mesh");
  return Refinement(mesh).to(panels);
}

}  // namespace uwsim
