#include "uwsim/sonar/echo.h"

#include <algorithm>
#include <array>

namespace uwsim {
namespace {

constexpr float kReach = 15.0f / 16;

/// What `ray` adds to the envelope at `range_m`.
float shape(const RayEcho& ray, float range_m, float cell_m) {
  const float reach = kReach * ray.width_m;
  const float u = (range_m - ray.range_m) / reach;
  const float rest = 1 - u * u;
  return rest > 0 ? ray.energy * cell_m / ray.width_m * rest * rest : 0;
}

bool touch(const RayEcho& a, const RayEcho& b) { return b.range_m - a.range_m < kReach * (a.width_m + b.width_m); }

/// By insertion: a beam has a handful, often in order already.
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
  for (std::size_t k = 0; k < rays.size(); ++k) {
    float height = 0;
    for (const RayEcho& ray : rays) height += shape(ray, rays[k].range_m, cell_m);
    if (height > echo.peak) {
      echo.peak = height;
      highest = k;
    }
  }
  if (echo.peak == 0) return echo;

  std::size_t first = highest, last = highest;
  while (first > 0 && touch(rays[first - 1], rays[first])) --first;
  while (last + 1 < rays.size() && touch(rays[last], rays[last + 1])) ++last;
  const float base_m = rays[highest].range_m;  // differences from it keep float's last digits
  float near_peak = 0, peak_shift = 0, centre_shift = 0, strongest = 0;
  for (std::size_t k = first; k <= last; ++k) {
    const float here = shape(rays[k], base_m, cell_m), shift_m = rays[k].range_m - base_m;
    near_peak += here;
    peak_shift += here * shift_m;
    echo.energy += rays[k].energy;
    centre_shift += rays[k].energy * shift_m;
    if (rays[k].energy > strongest) {
      strongest = rays[k].energy;
      echo.cosine = rays[k].cosine;
      echo.label = rays[k].label;
    }
  }
  echo.peak_range_m = base_m + peak_shift / near_peak;
  echo.centre_range_m = base_m + centre_shift / echo.energy;
  return echo;
}

}  // namespace uwsim
