#include "uwsim/sonar/echo.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace uwsim {
namespace {

constexpr float kReach = 15.0f / 16;

/// The rays as a structure of arrays, for vectorisation: each adds height (1 - (r - range)^2 / reach^2)^2 to the
/// envelope at ranges r within its reach. `kRays`: their number, or Eigen::Dynamic.
template <int kRays>
struct Shapes {
  using Lanes = Eigen::Array<float, kRays, 1, 0, kRays == Eigen::Dynamic ? kRaysMax : kRays, 1>;
  Lanes range_m, per_reach2, height;

  Shapes(std::span<const RayEcho> rays, float cell_m) {
    const auto n = static_cast<Eigen::Index>(rays.size());
    range_m.resize(n);
    per_reach2.resize(n);
    height.resize(n);
    for (Eigen::Index k = 0; k < n; ++k) {
      const RayEcho& ray = rays[static_cast<std::size_t>(k)];
      range_m[k] = ray.range_m;
      per_reach2[k] = ray.width_m;
      height[k] = ray.energy;
    }
    const Lanes per_width = 1 / per_reach2;
    per_reach2 = per_width * per_width / (kReach * kReach);
    height = height * cell_m * per_width;
  }

  /// The contribution of each ray at a range.
  auto parts(float at_m) const { return (1 - (range_m - at_m).square() * per_reach2).max(0.0f).square() * height; }
};

/// The largest value of the envelope at any of the rays' ranges, and the ray where it is found.
struct Peak {
  float height = 0;
  std::size_t ray = 0;
};

template <int kRays>
Peak peak(std::span<const RayEcho> rays, float cell_m) {
  const Shapes<kRays> shapes(rays, cell_m);
  Peak highest;
  for (std::size_t k = 0; k < rays.size(); ++k) {
    const float height = shapes.parts(rays[k].range_m).sum();
    if (height > highest.height) highest = {height, k};
  }
  return highest;
}

bool touch(const RayEcho& a, const RayEcho& b) { return b.range_m - a.range_m < kReach * (a.width_m + b.width_m); }

/// Insertion sort: a beam has few rays, often already in order.
void sort_by_range(std::span<RayEcho> rays) {
  for (std::size_t k = 1; k < rays.size(); ++k) {
    const RayEcho moved = rays[k];
    std::size_t to = k;
    for (; to > 0 && rays[to - 1].range_m > moved.range_m; --to) rays[to] = rays[to - 1];
    rays[to] = moved;
  }
}

}  // namespace

BeamEcho beam_echo(std::span<RayEcho> rays, float cell_m) {
  BeamEcho echo;
  if (rays.empty()) return echo;
  sort_by_range(rays);
  constexpr int kUsual = 8;  // the default number of a beam's rays
  const auto [height, highest] =
      rays.size() == kUsual ? peak<kUsual>(rays, cell_m) : peak<Eigen::Dynamic>(rays, cell_m);
  echo.peak = height;
  if (echo.peak == 0) return echo;

  std::size_t first = highest, last = highest;
  while (first > 0 && touch(rays[first - 1], rays[first])) --first;
  while (last + 1 < rays.size() && touch(rays[last], rays[last + 1])) ++last;
  const float base_m = rays[highest].range_m;  // differences from it preserve the precision of float
  float centre_shift = 0, strongest = 0;
  for (std::size_t k = first; k <= last; ++k) {
    echo.energy += rays[k].energy;
    centre_shift += rays[k].energy * (rays[k].range_m - base_m);
    if (rays[k].energy > strongest) {
      strongest = rays[k].energy;
      echo.cosine = rays[k].cosine;
      echo.label = rays[k].label;
    }
  }
  echo.centre_range_m = base_m + centre_shift / echo.energy;
  echo.rays = rays.subspan(first, last + 1 - first);
  return echo;
}

float envelope(std::span<const RayEcho> rays, float at_m, float cell_m) {
  float height = 0;
  for (const RayEcho& ray : rays) {
    const float per_width = 1 / ray.width_m;
    const float off = (ray.range_m - at_m) * per_width / kReach;
    const float inside = std::max(0.0f, 1 - off * off);
    height += inside * inside * ray.energy * cell_m * per_width;
  }
  return height;
}

double axis_range_m(std::span<const RayEcho> echo, const BeamRays& beam) {
  const auto inverse_along_axis = [&](const RayEcho& ray) {
    return double{1 / (ray.range_m * beam.directions.col(ray.ray).dot(beam.axis))};
  };
  double inverse = 0;
  // The offsets of all rays have mean 0, so the line crosses the axis at the mean
  if (echo.size() == beam.offsets.size()) {
    for (const RayEcho& ray : echo) inverse += inverse_along_axis(ray);
    return static_cast<double>(echo.size()) / inverse;
  }
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  double lowest = 0, highest = 0;
  for (const RayEcho& ray : echo) {
    const Eigen::Vector2d& offset = beam.offsets[ray.ray];
    const Eigen::Vector3d row(1, offset.x(), offset.y());
    normal += row * row.transpose();
    right += row * inverse_along_axis(ray);
    lowest = std::min(lowest, offset.x());
    highest = std::max(highest, offset.x());
  }
  constexpr double kSolvable = 1e-3;  // the determinant of fewer than three rays, or of collinear ones, is smaller
  const double count = static_cast<double>(echo.size());
  if (lowest == 0 || highest == 0 || normal.determinant() < kSolvable * count * count * count) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  inverse = normal.inverse().row(0).dot(right);
  return inverse > 0 ? 1 / inverse : std::numeric_limits<double>::quiet_NaN();
}

AxisEcho axis_echo(const BeamEcho& echo, const BeamRays& beam, double axis_m, float cell_m) {
  if (echo.rays.size() != beam.offsets.size()) {
    return {envelope(echo.rays, static_cast<float>(axis_m), cell_m), echo.extent_m(cell_m)};
  }
  const double count = static_cast<double>(echo.rays.size());
  double shift_m = 0, square_m2 = 0, point_m2 = 0;
  for (const RayEcho& ray : echo.rays) {
    const double along_m = double{ray.range_m} - axis_m;
    shift_m += along_m;
    square_m2 += along_m * along_m;
    point_m2 += ray.point_m2;
  }
  const double mean_m = shift_m / count, variance_m2 = square_m2 / count - mean_m * mean_m;
  const double extent_m = std::sqrt(2 * std::numbers::pi * variance_m2 + point_m2 / count);
  const double pulled_m = echo.centre_range_m - axis_m - mean_m;
  const double on_axis = variance_m2 > 0 ? std::exp(-0.5 * pulled_m * pulled_m / variance_m2) : 1;
  return {on_axis * echo.energy * cell_m / extent_m, extent_m};
}

}  // namespace uwsim
