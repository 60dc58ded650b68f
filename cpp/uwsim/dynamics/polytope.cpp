#include "uwsim/dynamics/polytope.h"

#include <LinearMath/btConvexHullComputer.h>

#include <Eigen/Geometry>

#include "uwsim/dynamics/bullet_memory.h"

namespace uwsim {
namespace {

constexpr double kShortest_m = 1e-9;  // shorter edges have no reliable direction

/// Computes a face from its corners in order (Newell's method). It faces outward because Bullet winds faces
/// counter-clockwise.
Polytope::Face face_of(const std::vector<int>& loop, const ConvexPiece& corners_m) {
  Eigen::Vector3d area = Eigen::Vector3d::Zero(), middle = Eigen::Vector3d::Zero();
  const auto corner = [&](std::size_t k) { return corners_m[static_cast<std::size_t>(loop[k % loop.size()])]; };
  for (std::size_t k = 0; k < loop.size(); ++k) {
    area += (corner(k) - corner(0)).cross(corner(k + 1) - corner(0));
    middle += corner(k);
  }
  const Eigen::Vector3d normal = area.normalized();
  return {normal, normal.dot(middle) / static_cast<double>(loop.size())};
}

}  // namespace

Polytope::Polytope(const ConvexPiece& points_m) {
  btConvexHullComputer hull;
  hull.compute(points_m.front().data(), sizeof(Eigen::Vector3d), static_cast<int>(points_m.size()), 0, 0);
  for (int k = 0; k < hull.vertices.size(); ++k) {
    const btVector3& v = hull.vertices[k];
    corners_m.emplace_back(v.x(), v.y(), v.z());
  }
  std::vector<std::size_t> face_on_left(static_cast<std::size_t>(hull.edges.size()));
  for (int f = 0; f < hull.faces.size(); ++f) {
    const btConvexHullComputer::Edge* const first = &hull.edges[hull.faces[f]];
    std::vector<int> loop;
    const btConvexHullComputer::Edge* edge = first;
    do {
      loop.push_back(edge->getSourceVertex());
      face_on_left[static_cast<std::size_t>(edge - &hull.edges[0])] = static_cast<std::size_t>(f);
      edge = edge->getNextEdgeOfFace();
    } while (edge != first);
    faces.push_back(face_of(loop, corners_m));
  }
  for (int e = 0; e < hull.edges.size(); ++e) {
    const btConvexHullComputer::Edge& edge = hull.edges[e];
    const auto reverse = static_cast<std::size_t>(edge.getReverseEdge() - &hull.edges[0]);
    if (reverse < static_cast<std::size_t>(e)) continue;
    const auto from = static_cast<std::uint32_t>(edge.getSourceVertex());
    const auto to = static_cast<std::uint32_t>(edge.getTargetVertex());
    const Eigen::Vector3d way = corners_m[to] - corners_m[from];
    if (way.norm() < kShortest_m) continue;
    const Eigen::Vector3d along = way.normalized();
    const Face &left = faces[face_on_left[static_cast<std::size_t>(e)]], &right = faces[face_on_left[reverse]];
    edges.push_back({from, to, way.norm(), along, {left.normal.cross(along), along.cross(right.normal)}});
  }
}

}  // namespace uwsim
