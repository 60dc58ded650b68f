#include "uwsim/rays/widened_triangle.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "uwsim/rays/tolerances.h"

namespace uwsim {
namespace {

/// Whether a corner is sharper than 14 degrees; moving the edges outward would move such a corner too far.
bool has_sharp_corner(const Corners& triangle) {
  const auto side = [&](std::size_t k) { return (triangle[(k + 1) % 3] - triangle[k % 3]).stableNormalized(); };
  const auto is_sharp = [&](std::size_t k) { return 0.5 * (side(k) + side(k + 2)).norm() * kLongestMitre < 1; };
  return is_sharp(0) || is_sharp(1) || is_sharp(2);
}

/// Returns a triangle around a sliver. The longest side, a to b, is moved outward by the widening; the other two sides
/// pass the sliver's corners at a distance of more than the widening.
Corners widened_sliver(const Corners& triangle, double widening_m) {
  std::size_t first = 0;
  const auto length = [&](std::size_t k) { return (triangle[(k + 1) % 3] - triangle[k]).squaredNorm(); };
  for (const std::size_t k : {1, 2}) first = length(k) > length(first) ? k : first;
  const Eigen::Vector3d &a = triangle[first], &b = triangle[(first + 1) % 3], &c = triangle[(first + 2) % 3];
  const Eigen::Vector3d along = (b - a).stableNormalized(), up = (c - a) - along.dot(c - a) * along;
  const Eigen::Vector3d across = up.stableNormalized();
  const double height = up.norm(), apex = height + 4 * widening_m, foot = std::max(0.0, along.dot(c - a));
  const auto beyond = [&](double to_foot) {  // returns how far the base extends beyond a or b
    return std::max(widening_m * (2 * to_foot + height + 5 * widening_m) / (height + 3 * widening_m),
                    0.5 * (apex + widening_m));
  };
  Corners wide;
  wide[first] = a - beyond(foot) * along - widening_m * across;
  wide[(first + 1) % 3] = b + beyond(std::max(0.0, (b - a).norm() - foot)) * along - widening_m * across;
  wide[(first + 2) % 3] = a + foot * along + apex * across;
  return wide;
}

}  // namespace

Corners widened(const Corners& triangle, double widening_m) {
  if (has_sharp_corner(triangle)) return widened_sliver(triangle, widening_m);
  constexpr double kFlatCorner = 1e-9;  // a corner of 180 degrees has no inside to move away from
  Corners wide = triangle;
  for (std::size_t k = 0; k < 3; ++k) {
    const Eigen::Vector3d one = (triangle[(k + 1) % 3] - triangle[k]).stableNormalized();
    const Eigen::Vector3d two = (triangle[(k + 2) % 3] - triangle[k]).stableNormalized();
    const Eigen::Vector3d inward = one + two;
    const double sine = 0.5 * (one - two).norm(), cosine = 0.5 * inward.norm();  // of half the corner's angle
    if (cosine < kFlatCorner) continue;
    wide[k] -= widening_m / sine * inward / (2 * cosine);
  }
  return wide;
}

/// The triangle's sides are where one coordinate is at most this, so that none crosses the triangle where all are more.
float margin_within(const Corners& wide, const Corners& triangle) {
  constexpr double kRounding = 1e-4;
  const Eigen::Vector3d normal = (wide[1] - wide[0]).cross(wide[2] - wide[0]);
  double most = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Eigen::Vector3d &one = wide[(k + 1) % 3], &two = wide[(k + 2) % 3];
    for (const std::size_t j : {k + 1, k + 2}) {
      const Eigen::Vector3d& corner = triangle[j % 3];
      most = std::max(most, (one - corner).cross(two - corner).dot(normal) / normal.squaredNorm());
    }
  }
  return most < 1.0 / 3 && normal.squaredNorm() > 0 ? static_cast<float>(most + kRounding) : 1;
}

}  // namespace uwsim
