#include "uwsim/world/ray_walk.h"

#include <algorithm>
#include <cmath>

namespace uwsim {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kEdge = 1e-9;  // cells

/// A ray over a block of cells, whose sides are the unit of length across.
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
      if (above_m(at_m) > surfaces_.clearance_m()) {
        walk.clear_to_m = at_m;
        return walk;
      }
      walk.set_out = true;
      walk.crossed = walk.crossed || surfaces_.is_crossed(2 * number());
      meet(1, walk.hit);
      meet(-1, walk.hit);
      if (walk.hit) return walk;
    }
    return walk;
  }

 private:
  /// What of the ray from first to last is between 0 and `count`, edges included.
  static bool clip(double start, double way, double count, double& first, double& last) {
    if (way == 0) return start >= -kEdge && start <= count + kEdge;
    const double one = (-kEdge - start) / way, two = (count + kEdge - start) / way;
    first = std::max(first, std::min(one, two));
    last = std::min(last, std::max(one, two));
    return first <= last;
  }

  static std::int64_t cell(double at, std::uint32_t count) {
    return static_cast<std::int64_t>(std::clamp(std::floor(at), 0.0, count - 1.0));
  }

  bool inside() const { return i_ >= 0 && j_ >= 0 && i_ < block_.columns && j_ < block_.rows; }
  std::uint32_t number() const { return static_cast<std::uint32_t>(j_ * block_.columns + i_); }

  /// Of the cell's corner, or of its far one.
  const float* height(bool far_corner) const {
    const std::int64_t column = block_.first_column + i_ + far_corner, row = block_.first_row + j_ + far_corner;
    return block_.heights_m + row * block_.row_length + column;
  }

  /// To the next cell; returns how far that is along the ray.
  double step() {
    const double to_x = dx_ == 0 ? kInfinity : (static_cast<double>(i_ + (dx_ > 0)) - x_) / dx_;
    const double to_y = dy_ == 0 ? kInfinity : (static_cast<double>(j_ + (dy_ > 0)) - y_) / dy_;
    if (to_x == kInfinity && to_y == kInfinity) return kInfinity;
    (to_x < to_y ? i_ : j_) += (to_x < to_y ? dx_ : dy_) > 0 ? 1 : -1;
    return std::min(to_x, to_y);
  }

  double above_m(double at_m) const {
    const double a = x_ + at_m * dx_ - static_cast<double>(i_), b = y_ + at_m * dy_ - static_cast<double>(j_);
    const bool far_corner = a + b > 1;
    const double side = far_corner ? -1 : 1, u = far_corner ? 1 - a : a, v = far_corner ? 1 - b : b;
    const float* here = height(far_corner);
    const auto way = static_cast<std::ptrdiff_t>(side), row = way * static_cast<std::ptrdiff_t>(block_.row_length);
    const double up = *here + u * (double{here[way]} - *here) + v * (double{here[row]} - *here);
    return ray_.origin_world_m.z() + at_m * ray_.direction_world.z() - up;
  }

  /// With the cell's triangle at its corner (side 1) or far corner (-1); the same arithmetic as the kernel's.
  void meet(int side, std::optional<TileHit>& hit) const {
    const float* here = height(side < 0);
    const double slope_x = side * (double{here[side]} - *here);  // metres a cell
    const double slope_y = side * (double{here[side * static_cast<std::ptrdiff_t>(block_.row_length)]} - *here);
    const double column = static_cast<double>(block_.first_column + i_ + (side < 0));
    const double row = static_cast<double>(block_.first_row + j_ + (side < 0));
    const double u = (ray_.origin_world_m.x() - block_.origin_x) * block_.cells_per_m - column;
    const double v = (ray_.origin_world_m.y() - block_.origin_y) * block_.cells_per_m - row;
    const double distance_m = (*here + slope_x * u + slope_y * v - ray_.origin_world_m.z()) /
                              (ray_.direction_world.z() - slope_x * dx_ - slope_y * dy_);
    const double a = side * (u + distance_m * dx_), b = side * (v + distance_m * dy_);
    const bool met = a >= -kSeam && b >= -kSeam && a + b <= 1 + kSeam && distance_m >= from_m_;
    if (!met || distance_m > ray_.far_m || (hit && hit->distance_m <= distance_m)) return;
    const Eigen::Vector3d up(-slope_x * block_.cells_per_m, -slope_y * block_.cells_per_m, 1);
    hit = TileHit{distance_m, up.normalized(), false};
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
