#include "uwsim/world/sampled_triangle.h"

#include <limits>

namespace uwsim {
namespace {

// A triangle with fewer rows is so thin that rounding dominates the direction from edge a-b to corner c
constexpr std::int64_t kFlatRows = 4;
constexpr int kMostCorners = 9;  // of a triangle cut by six planes

/// A convex polygon that is cut by planes, one at a time.
struct Polygon {
  std::array<Eigen::Vector3d, kMostCorners> corners;
  int count;

  /// Keeps the part where sign * x[axis] <= sign * at (Sutherland and Hodgman 1974, Comm. ACM 17(1)).
  void cut(int axis, double at, double sign) {
    const Polygon whole = *this;
    count = 0;
    for (int k = 0; k < whole.count; ++k) {
      const Eigen::Vector3d &here = whole.corners[static_cast<std::size_t>(k)],
                            &next = whole.corners[static_cast<std::size_t>((k + 1) % whole.count)];
      const double beyond = sign * (here[axis] - at), next_beyond = sign * (next[axis] - at);
      if (beyond <= 0) add(here);
      if ((beyond <= 0) != (next_beyond <= 0)) add(here + beyond / (beyond - next_beyond) * (next - here));
    }
  }

  double area() const {
    Eigen::Vector3d doubled = Eigen::Vector3d::Zero();
    for (int k = 2; k < count; ++k) {
      const auto from_first = [&](int i) { return (corners[static_cast<std::size_t>(i)] - corners[0]).eval(); };
      doubled += from_first(k - 1).cross(from_first(k));
    }
    return doubled.norm() / 2;
  }

 private:
  void add(const Eigen::Vector3d& corner) {
    if (count < kMostCorners) corners[static_cast<std::size_t>(count++)] = corner;
  }
};

}  // namespace

SampledTriangle::SampledTriangle(const std::array<Eigen::Vector3d, 3>& corners_m, double spacing_m) {
  std::size_t longest = 0;
  double base_m = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    bounds_m_.extend(corners_m[k]);
    const double edge_m = (corners_m[(k + 1) % 3] - corners_m[k]).norm();
    if (edge_m <= base_m) continue;
    longest = k;
    base_m = edge_m;
  }
  a_m_ = corners_m[longest];
  b_m_ = corners_m[(longest + 1) % 3];
  c_m_ = corners_m[(longest + 2) % 3];
  const double height_m = (b_m_ - a_m_).cross(c_m_ - a_m_).norm() / std::max(base_m, 1e-12);
  columns_ = static_cast<std::int64_t>(std::ceil(base_m / spacing_m));
  rows_ = std::max(static_cast<std::int64_t>(std::ceil(height_m / spacing_m)), std::int64_t{1});
}

SampledTriangle::Range SampledTriangle::heights_within(const Eigen::AlignedBox3d& box_m) const {
  if (rows_ < kFlatRows) return {0, 1};
  const Eigen::Vector3d along = (b_m_ - a_m_).normalized(), to_c = c_m_ - a_m_;
  const Eigen::Vector3d upright = to_c - to_c.dot(along) * along;
  const Eigen::Vector3d slope = upright / std::max(upright.squaredNorm(), 1e-24);
  const double middle = (box_m.center() - a_m_).dot(slope), reach = slope.cwiseAbs().dot(box_m.sizes() / 2);
  return {std::clamp(middle - reach, 0.0, 1.0), std::clamp(middle + reach, 0.0, 1.0)};
}

SampledTriangle::Range SampledTriangle::part_within(const Eigen::AlignedBox3d& box_m, double up) const {
  constexpr Range kNever = {1, 0};
  const Eigen::Vector3d start = (1 - up) * a_m_ + up * c_m_, direction = (1 - up) * (b_m_ - a_m_);
  Range part{0, 1};
  for (int axis = 0; axis < 3; ++axis) {
    const double to_low = box_m.min()[axis] - start[axis], to_high = box_m.max()[axis] - start[axis];
    if (direction[axis] == 0) {
      if (to_low > 0 || to_high < 0) return kNever;
      continue;
    }
    const double one = to_low / direction[axis], other = to_high / direction[axis];
    part = {std::max(part.low, std::min(one, other)), std::min(part.high, std::max(one, other))};
  }
  return part.low <= part.high ? part : kNever;
}

double area_within_m2(const std::array<Eigen::Vector3d, 3>& corners_m, const Eigen::AlignedBox3d& box_m) {
  Polygon polygon{{corners_m[0], corners_m[1], corners_m[2]}, 3};
  for (int axis = 0; axis < 3 && polygon.count > 0; ++axis) {
    if (std::isfinite(box_m.max()[axis])) polygon.cut(axis, box_m.max()[axis], 1);
    if (std::isfinite(box_m.min()[axis]) && polygon.count > 0) polygon.cut(axis, box_m.min()[axis], -1);
  }
  return polygon.area();
}

}  // namespace uwsim
