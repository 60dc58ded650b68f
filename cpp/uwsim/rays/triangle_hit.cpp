#include "uwsim/rays/triangle_hit.h"

#include <Eigen/Geometry>

#include "uwsim/rays/tolerances.h"

namespace uwsim {

std::optional<TileHit> meet_triangle(const Corners& triangle, const TileRay& ray, double edge_margin_m) {
  const Eigen::Vector3d ab = triangle[1] - triangle[0], ac = triangle[2] - triangle[0];
  const Eigen::Vector3d normal = ab.cross(ac);
  const double along = normal.dot(ray.direction_world);
  if (along == 0) return {};
  const Eigen::Vector3d from_a = ray.origin_world_m - triangle[0];
  const Eigen::Vector3d moment = ray.direction_world.cross(from_a);
  const double u = ac.dot(moment) / along, v = -ab.dot(moment) / along, w = 1 - u - v;
  if (!(u >= -kSeam && v >= -kSeam && w >= -kSeam)) return {};
  const double area = normal.norm();  // twice the area of the triangle
  const bool clear = u * area > edge_margin_m * ac.norm() && v * area > edge_margin_m * ab.norm() &&
                     w * area > edge_margin_m * (ac - ab).norm();
  return TileHit{-normal.dot(from_a) / along, normal / area, clear};
}

}  // namespace uwsim
