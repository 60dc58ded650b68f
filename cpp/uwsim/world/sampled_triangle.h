#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace uwsim {

/// A triangle covered by a grid of sample points, in rows parallel to its longest edge a-b that get shorter towards its
/// corner c. Neither rows nor points within a row are further apart than the spacing.
class SampledTriangle {
 public:
  SampledTriangle(const std::array<Eigen::Vector3d, 3>& corners_m, double spacing_m);

  /// Calls visit(point_m) for the points in a box, and for a few outside it, in an order that does not depend on the
  /// box.
  template <typename Visit>
  void visit_points(const Eigen::AlignedBox3d& box_m, const Visit& visit) const {
    const bool inside = box_m.contains(bounds_m_);
    const Range heights = inside ? Range{0, 1} : heights_within(box_m);
    const auto [first_row, last_row] = steps_within(heights, rows_);
    for (std::int64_t row = first_row; row <= last_row; ++row) {
      const double up = static_cast<double>(row) / static_cast<double>(rows_);
      const auto steps = static_cast<std::int64_t>(std::ceil(static_cast<double>(columns_) * (1 - up)));
      const Range part = inside ? Range{0, 1} : part_within(box_m, up);
      if (part.low > part.high) continue;
      const auto [first, last] = steps_within(part, steps);
      for (std::int64_t column = first; column <= last; ++column) {
        const double along = steps == 0 ? 0 : static_cast<double>(column) / static_cast<double>(steps);
        visit((1 - up) * ((1 - along) * a_m_ + along * b_m_) + up * c_m_);
      }
    }
  }

 private:
  struct Range {
    double low, high;
  };
  struct Steps {
    std::int64_t first, last;
  };

  /// The steps, `count` of them from 0 to 1, that fall within a range, plus one at either end to allow for rounding.
  static Steps steps_within(const Range& range, std::int64_t count) {
    const auto steps = static_cast<double>(count);
    return {std::max(static_cast<std::int64_t>(std::floor(range.low * steps)) - 1, std::int64_t{0}),
            std::min(static_cast<std::int64_t>(std::ceil(range.high * steps)) + 1, count)};
  }
  /// Bounds on how far the part inside the box extends from edge a-b (0) towards corner c (1).
  Range heights_within(const Eigen::AlignedBox3d& box_m) const;
  /// Where the row at this height enters and leaves the box, as fractions of the row; low > high if it misses the box.
  Range part_within(const Eigen::AlignedBox3d& box_m, double up) const;

  Eigen::Vector3d a_m_, b_m_, c_m_;
  Eigen::AlignedBox3d bounds_m_;
  std::int64_t columns_, rows_;
};

/// The area of the part of a triangle that lies in a box [m^2].
double area_within_m2(const std::array<Eigen::Vector3d, 3>& corners_m, const Eigen::AlignedBox3d& box_m);

}  // namespace uwsim
