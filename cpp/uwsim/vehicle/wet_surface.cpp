#include "uwsim/vehicle/wet_surface.h"

#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>

namespace uwsim {
namespace {

using WetCorners = std::vector<Eigen::Vector3d>;

/// The part of a polygon where normal . r < level_m, or at it, too (Sutherland and Hodgman 1974, Comm. ACM 17:32). An
/// infinite level cuts nothing off.
WetCorners part_below(const WetCorners& polygon, const Eigen::Vector3d& normal, double level_m, bool or_at = false) {
  if (std::isinf(level_m)) return polygon;
  WetCorners part;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Eigen::Vector3d &from = polygon[k], &to = polygon[(k + 1) % polygon.size()];
    const double above = normal.dot(from) - level_m, next_above = normal.dot(to) - level_m;
    const auto is_below = [or_at](double height) { return height < 0 || (or_at && height == 0); };
    if (is_below(above)) part.push_back(from);
    if (is_below(above) != is_below(next_above)) part.push_back(from + above / (above - next_above) * (to - from));
  }
  return part;
}

}  // namespace

WetSurface cut_at_surface(const TriangleMesh& mesh_body, const std::vector<WaterPlane>& planes,
                          const Eigen::Vector3d& position_world_m, const Eigen::Matrix3d& world_from_body,
                          const WaterField& water, double time_s) {
  WetSurface wet;
  for (const WaterPlane& plane : planes) {
    const Eigen::Vector3d along = Eigen::Vector3d::Unit(plane.axis);
    for (const Triangle& t : mesh_body.triangles) {
      WetCorners part = {mesh_body.vertices_m[t[0]], mesh_body.vertices_m[t[1]], mesh_body.vertices_m[t[2]]};
      part = part_below(part, along, plane.to_m);
      part = part_below(part, -along, -plane.from_m, true);
      part = part_below(part, plane.up_body, plane.level_m);
      for (std::size_t k = 2; k < part.size(); ++k) {
        const Eigen::Vector3d &a = part[0], &b = part[k - 1], &c = part[k];
        const Eigen::Vector3d area = 0.5 * (b - a).cross(c - a);  // along the outward normal
        if (area.squaredNorm() == 0) continue;
        const Eigen::Vector3d centre = position_world_m + world_from_body * ((a + b + c) / 3);
        const Eigen::Vector3d force = -water.still_pressure_at(-water.pressure_head_at(centre, time_s)) * area;
        for (const Eigen::Vector3d* corner : {&a, &b, &c})
          wet.corners_body_m.insert(wet.corners_body_m.end(), corner->begin(), corner->end());
        wet.forces_body_n.insert(wet.forces_body_n.end(), force.begin(), force.end());
      }
    }
  }
  return wet;
}

}  // namespace uwsim
