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

Eigen::Vector3d closest_on_triangle(const Eigen::Vector3d& p, const Corners& triangle) {
  const auto& [a, b, c] = triangle;
  const Eigen::Vector3d ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap), d3 = ab.dot(bp), d4 = ac.dot(bp), d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d1 <= 0 && d2 <= 0) return a;
  if (d3 >= 0 && d4 <= d3) return b;
  if (d6 >= 0 && d5 <= d6) return c;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0 && d1 > d3) return a + d1 / (d1 - d3) * ab;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0 && d2 > d6) return a + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  const double along_bc = (d4 - d3) + (d5 - d6);
  if (va <= 0 && d4 >= d3 && d5 >= d6 && along_bc > 0) return b + (d4 - d3) / along_bc * (c - b);
  const double whole = va + vb + vc;
  return whole > 0 ? Eigen::Vector3d(a + (vb * ab + vc * ac) / whole) : a;
}

}  // namespace uwsim
