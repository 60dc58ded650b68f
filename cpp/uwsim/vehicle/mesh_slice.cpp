#include "uwsim/vehicle/mesh_slice.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace uwsim {
namespace {

using Polygon = std::vector<Eigen::Vector3d>;

void add(TriangleMesh& mesh, const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices_m.size());
  mesh.vertices_m.insert(mesh.vertices_m.end(), {a, b, c});
  mesh.triangles.push_back({first, first + 1, first + 2});
}

/// Keeps the part of a polygon where side (r_axis - level_m) <= 0 (Sutherland and Hodgman 1974, Comm. ACM 17:32). New
/// corners are on the plane to the last bit.
Polygon clipped(const Polygon& polygon, Eigen::Index axis, double level_m, double side) {
  Polygon out;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Eigen::Vector3d &from = polygon[k], &to = polygon[(k + 1) % polygon.size()];
    const double above = side * (from(axis) - level_m), next_above = side * (to(axis) - level_m);
    if (above <= 0) out.push_back(from);
    if ((above < 0 && next_above > 0) || (above > 0 && next_above < 0)) {
      Eigen::Vector3d& crossing = out.emplace_back(from + above / (above - next_above) * (to - from));
      crossing(axis) = level_m;
    }
  }
  return out;
}

}  // namespace

/// Clipping leaves open edges on a plane, which form closed curves. A fan from any point of the plane to the reversed
/// edges closes them; edges shared by two polygons add two triangles that cancel.
TriangleMesh slice_between(const TriangleMesh& mesh, Eigen::Index axis, double low_m, double high_m) {
  TriangleMesh slice;
  for (const Triangle& t : mesh.triangles) {
    const Polygon whole = {mesh.vertices_m[t[0]], mesh.vertices_m[t[1]], mesh.vertices_m[t[2]]};
    const Polygon part = clipped(clipped(whole, axis, low_m, -1), axis, high_m, 1);
    for (std::size_t k = 2; k < part.size(); ++k) add(slice, part[0], part[k - 1], part[k]);
    for (std::size_t k = 0; k < part.size(); ++k) {
      const Eigen::Vector3d &from = part[k], &to = part[(k + 1) % part.size()];
      for (const double level_m : {low_m, high_m}) {
        if (from(axis) == level_m && to(axis) == level_m) add(slice, level_m * Eigen::Vector3d::Unit(axis), to, from);
      }
    }
  }
  return slice;
}

}  // namespace uwsim
