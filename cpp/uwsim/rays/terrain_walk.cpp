#include "uwsim/rays/terrain_walk.h"

#include <algorithm>
#include <cmath>

#include "uwsim/core/infinity.h"
#include "uwsim/rays/terrain_hit.h"

namespace uwsim {
namespace {

/// A ray over a block of cells. Horizontal positions are in cells from the block's corner.
class Walk {
 public:
  Walk(const TileSurfaces& surfaces, const TileRay& ray, double from_m)
      : surfaces_(surfaces),
        ray_(ray),
        block_(surfaces.terrain_block()),
        from_m_(from_m),
        x_((ray.origin_world_m.x() - block_.origin_x) * block_.cells_per_m - block_.first_column),
        y_((ray.origin_world_m.y() - block_.origin_y) * block_.cells_per_m - block_.first_row),
        dx_(ray.direction_world.x() * block_.cells_per_m),
        dy_(ray.direction_world.y() * block_.cells_per_m) {}

  TerrainWalk run() {
    TerrainWalk walk;
    double first = from_m_, last = ray_.far_m;
    if (!clip(x_, dx_, block_.columns, first, last) || !clip(y_, dy_, block_.rows, first, last)) return walk;
    double at_m = first;
    i_ = cell(x_ + at_m * dx_, block_.columns);
    j_ = cell(y_ + at_m * dy_, block_.rows);
    for (; inside() && at_m <= last && at_m < kInfinity; at_m = step()) {
      if (height_above_terrain_m(at_m) > block_.clearance_m) {
        walk.clear_to_m = at_m;
        return walk;
      }
      walk.began_low = true;
      walk.near_solids = walk.near_solids || surfaces_.is_near_solids(number());
      meet(1, walk.hit);
      meet(-1, walk.hit);
      if (walk.hit) return walk;
    }
    return walk;
  }

 private:
  /// Limits first and last to the part of the ray that lies between 0 and `count`, inclusive.
  static bool clip(double start, double direction, double count, double& first, double& last) {
    if (direction == 0) return start >= -kCellMargin && start <= count + kCellMargin;
    const double one = (-kCellMargin - start) / direction, two = (count + kCellMargin - start) / direction;
    first = std::max(first, std::min(one, two));
    last = std::min(last, std::max(one, two));
    return first <= last;
  }

  static std::int64_t cell(double at, std::uint32_t count) {
    return static_cast<std::int64_t>(std::clamp(std::floor(at), 0.0, count - 1.0));
  }

  bool inside() const { return i_ >= 0 && j_ >= 0 && i_ < block_.columns && j_ < block_.rows; }
  std::uint32_t number() const { return static_cast<std::uint32_t>(j_ * block_.columns + i_); }

  /// The height of the cell's near or far corner.
  const float* height(bool far_corner) const {
    const std::int64_t column = block_.first_column + i_ + far_corner, row = block_.first_row + j_ + far_corner;
    return block_.heights_m + row * block_.row_length + column;
  }

  /// Proceeds to the next cell; returns the distance along the ray at which it begins.
  double step() {
    const double to_x = dx_ == 0 ? kInfinity : (static_cast<double>(i_ + (dx_ > 0)) - x_) / dx_;
    const double to_y = dy_ == 0 ? kInfinity : (static_cast<double>(j_ + (dy_ > 0)) - y_) / dy_;
    if (to_x == kInfinity && to_y == kInfinity) return kInfinity;
    (to_x < to_y ? i_ : j_) += (to_x < to_y ? dx_ : dy_) > 0 ? 1 : -1;
    return std::min(to_x, to_y);
  }

  double height_above_terrain_m(double at_m) const {
    const double a = x_ + at_m * dx_ - static_cast<double>(i_), b = y_ + at_m * dy_ - static_cast<double>(j_);
    const bool far_corner = a + b > 1;
    const double u = far_corner ? 1 - a : a, v = far_corner ? 1 - b : b;
    const float* here = height(far_corner);
    const std::ptrdiff_t to_x = far_corner ? -1 : 1, to_y = to_x * static_cast<std::ptrdiff_t>(block_.row_length);
    const double terrain = *here + u * (double{here[to_x]} - *here) + v * (double{here[to_y]} - *here);
    return ray_.origin_world_m.z() + at_m * ray_.direction_world.z() - terrain;
  }

  /// Keeps the hit on the cell's triangle at its near corner (side 1) or far corner (-1) if that hit is nearer.
  void meet(int side, std::optional<TileHit>& nearest) const {
    const bool far_corner = side < 0;
    const float* here = height(far_corner);
    const TerrainTriangle triangle =
        terrain_triangle(side, static_cast<double>(block_.first_column + i_ + far_corner),
                         static_cast<double>(block_.first_row + j_ + far_corner), *here, here[side],
                         here[side * static_cast<std::ptrdiff_t>(block_.row_length)]);
    const Eigen::Vector3d &o = ray_.origin_world_m, &d = ray_.direction_world;
    const PlaneHit hit = meet_plane(triangle, block_, o.x(), o.y(), o.z(), d.x(), d.y(), d.z());
    const bool met = hit.a >= -kSeam && hit.b >= -kSeam && hit.a + hit.b <= 1 + kSeam && hit.distance_m >= from_m_;
    if (!met || hit.distance_m > ray_.far_m || (nearest && nearest->distance_m <= hit.distance_m)) return;
    // The kernel instead multiplies by the inverse of the length, which is faster; the results may differ in the last
    // bit.
    const Eigen::Vector3d up(-triangle.slope_x * block_.cells_per_m, -triangle.slope_y * block_.cells_per_m, 1);
    nearest = TileHit{hit.distance_m, up.normalized(), false};
  }

  const TileSurfaces& surfaces_;
  const TileRay& ray_;
  TerrainBlock block_;
  double from_m_, x_, y_, dx_, dy_;
  std::int64_t i_ = 0, j_ = 0;
};

}  // namespace

TerrainWalk walk_terrain(const TileSurfaces& surfaces, const TileRay& ray, double from_m) {
  if (surfaces.contents().columns == 0) return {};
  return Walk(surfaces, ray, from_m).run();
}

}  // namespace uwsim
