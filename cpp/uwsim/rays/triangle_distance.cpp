#include "uwsim/rays/triangle_distance.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace uwsim {
namespace {

/// Squared distance between the segments from a to b and from c to d (Ericson 2005, "Real-Time Collision Detection",
/// 5.1.9).
double segments_apart2(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                       const Eigen::Vector3d& d) {
  const Eigen::Vector3d ab = b - a, cd = d - c, ca = a - c;
  const double ab2 = ab.squaredNorm(), cd2 = cd.squaredNorm(), along_cd = cd.dot(ca);
  double s = 0, t = 0;  // fractions of ab and cd at the closest points
  if (ab2 > 0) {
    const double along_ab = ab.dot(ca), both = ab.dot(cd), denominator = ab2 * cd2 - both * both;
    if (cd2 > 0 && denominator > 0) s = std::clamp((both * along_cd - along_ab * cd2) / denominator, 0.0, 1.0);
    if (cd2 > 0) t = (both * s + along_cd) / cd2;
    const bool inside = cd2 > 0 && t >= 0 && t <= 1;
    t = std::clamp(t, 0.0, 1.0);
    if (!inside) s = std::clamp((both * t - along_ab) / ab2, 0.0, 1.0);
  } else if (cd2 > 0) {
    t = std::clamp(along_cd / cd2, 0.0, 1.0);
  }
  return (ca + s * ab - t * cd).squaredNorm();
}

/// Whether an edge of one triangle passes through the other.
bool pierces(const Corners& one, const Corners& other) {
  for (std::size_t k = 0; k < 3; ++k) {
    const Eigen::Vector3d edge = one[(k + 1) % 3] - one[k];
    const double length_m = edge.norm();
    if (!(length_m > 0)) continue;
    const auto hit = meet_triangle(other, {one[k], edge / length_m, length_m}, 0);
    if (hit && hit->distance_m >= 0 && hit->distance_m <= length_m) return true;
  }
  return false;
}

}  // namespace

/// The closest points of two triangles that do not intersect are on a corner and a triangle, or on two edges.
bool closer_than(const Corners& one, const Corners& other, double distance_m) {
  const double limit2 = distance_m * distance_m;
  for (std::size_t k = 0; k < 3; ++k) {
    if ((closest_on_triangle(one[k], other) - one[k]).squaredNorm() < limit2) return true;
    if ((closest_on_triangle(other[k], one) - other[k]).squaredNorm() < limit2) return true;
    for (std::size_t j = 0; j < 3; ++j) {
      if (segments_apart2(one[k], one[(k + 1) % 3], other[j], other[(j + 1) % 3]) < limit2) return true;
    }
  }
  return pierces(one, other) || pierces(other, one);
}

}  // namespace uwsim
