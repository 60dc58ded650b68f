#include "uwsim/rays/reached_tiles.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "uwsim/core/infinity.h"
#include "uwsim/rays/ray_lanes.h"

namespace uwsim {
namespace {

constexpr double kFarthest_m = 1e12;  // the end of an unlimited ray, for its bounding box

/// The distance at which the ray enters the box: 0 from inside, infinity if the ray misses the box or is not finite.
double entry_m(const Eigen::AlignedBox3d& box, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
               double far_m) {
  double first = 0, last = far_m;
  for (int axis = 0; axis < 3; ++axis) {
    const double to_low = box.min()(axis) - origin(axis), to_high = box.max()(axis) - origin(axis);
    if (direction(axis) == 0) {
      if (!(to_low <= 0 && to_high >= 0)) return kInfinity;
      continue;
    }
    const double one = to_low / direction(axis), two = to_high / direction(axis);
    if (!(std::isfinite(one) && std::isfinite(two))) return kInfinity;
    first = std::max(first, std::min(one, two));
    last = std::min(last, std::max(one, two));
  }
  return first <= last ? first : kInfinity;
}

/// The box around all active rays that are finite.
Eigen::AlignedBox3d box_of(const ExactRays& rays) {
  Eigen::AlignedBox3d box;
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    const Eigen::Vector3d end = origin_of(rays, k) + std::min(rays.far_m[k], kFarthest_m) * direction_of(rays, k);
    if (rays.active[k] == 0 || !end.allFinite()) continue;
    box.extend(origin_of(rays, k)).extend(end);
  }
  return box;
}

}  // namespace

std::vector<ReachedTile> reached_tiles(const std::vector<RayTile>& tiles, const ExactRays& rays) {
  const Eigen::AlignedBox3d swept = box_of(rays);
  std::vector<ReachedTile> found;
  for (const RayTile& tile : tiles) {
    if (!tile.box().intersects(swept)) continue;
    ReachedTile one{&tile, kInfinity, {}};
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      one.start_m[k] = rays.active[k] != 0
                           ? entry_m(tile.box(), origin_of(rays, k), direction_of(rays, k), rays.far_m[k])
                           : kInfinity;
      one.soonest_m = std::min(one.soonest_m, one.start_m[k]);
    }
    if (one.soonest_m < kInfinity) found.push_back(one);
  }
  // stable_sort is not used, because libstdc++ would merge in memory that is not aligned for a ReachedTile.
  std::ranges::sort(found, {}, [](const ReachedTile& one) { return std::pair(one.soonest_m, one.tile); });
  return found;
}

}  // namespace uwsim
