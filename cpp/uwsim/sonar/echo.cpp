#include "uwsim/sonar/echo.h"

#include <Eigen/Core>

namespace uwsim {
namespace {

constexpr float kReach = 15.0f / 16;

/// The rays as a structure of arrays, for vector units: each adds height (1 - (r - range)^2 / reach^2)^2 to the
/// envelope at a range r within its reach.
struct Shapes {
  using Lanes = Eigen::Array<float, Eigen::Dynamic, 1, 0, kRaysMax, 1>;
  Lanes range_m, per_reach2, height;

  Shapes(std::span<const RayEcho> rays, float cell_m) {
    const auto n = static_cast<Eigen::Index>(rays.size());
    range_m.resize(n);
    per_reach2.resize(n);
    height.resize(n);
    for (Eigen::Index k = 0; k < n; ++k) {
      const RayEcho& ray = rays[static_cast<std::size_t>(k)];
      const float per_width = 1 / ray.width_m;
      range_m[k] = ray.range_m;
      per_reach2[k] = per_width * per_width / (kReach * kReach);
      height[k] = ray.energy * cell_m * per_width;
    }
  }

  /// The contribution of each ray at a range.
  auto parts(float at_m) const { return (1 - (range_m - at_m).square() * per_reach2).max(0.0f).square() * height; }
};

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
  std::size_t highest = 0;
  const Shapes shapes(rays, cell_m);
  for (std::size_t k = 0; k < rays.size(); ++k) {
    const float height = shapes.parts(rays[k].range_m).sum();
    if (height > echo.peak) {
      echo.peak = height;
      highest = k;
    }
  }
  if (echo.peak == 0) return echo;

  std::size_t first = highest, last = highest;
  while (first > 0 && touch(rays[first - 1], rays[first])) --first;
  while (last + 1 < rays.size() && touch(rays[last], rays[last + 1])) ++last;
  const float base_m = rays[highest].range_m;  // differences from it keep the precision of float
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
  return echo;
}

}  // namespace uwsim
