#include <algorithm>
#include <cmath>

#include "uwsim/core/check.h"
#include "uwsim/mapping/occupancy_map_impl.h"

/// Members of OccupancyMap that check and insert scans.
namespace uwsim {
namespace {

/// OctoMap collects a ray's keys in a buffer of 100,000 and aborts the process when it is full.
constexpr double kRayStepsMax = 99'990;
// Below this, OctoMap's walk might not terminate, because floats cannot resolve the range
constexpr double kMaxRangeMin_m = 1e-9;
constexpr int kThreadsMax = 1024;

/// The maximum range in OctoMap's convention: negative for no limit.
double octomap_range_m(double max_range_m) {
  require(max_range_m >= kMaxRangeMin_m, "scan.max_range_m", max_range_m,
          "must be positive, and a nanometre at least (infinity: no limit)");
  return std::isinf(max_range_m) ? -1.0 : max_range_m;
}

}  // namespace

/// Throws unless every point lies inside the cube and no ray is too long for OctoMap. Checks the box around the points
/// first, and individual points only if the box is too large.
void OccupancyMap::Impl::check_points(const Scan& scan, double max_range_m) const {
  float lowest[3], highest[3];
  for (int axis = 0; axis < 3; ++axis) lowest[axis] = highest[axis] = scan.origin_m[axis] + float(origin_world_m[axis]);
  const float* const points = scan.points_world_m.data();
  const std::size_t count = scan.points_world_m.size() / 3;
  bool all_finite = true;
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float x = points[3 * i + axis];
      all_finite = all_finite && x - x == 0;
      lowest[axis] = x < lowest[axis] ? x : lowest[axis];
      highest[axis] = x > highest[axis] ? x : highest[axis];
    }
  }
  const Eigen::Vector3d low_world_m(lowest[0], lowest[1], lowest[2]), high_world_m(highest[0], highest[1], highest[2]);
  const auto steps_bound = [&](double reach_m) { return std::sqrt(3.0) * reach_m / resolution_m; };
  if (all_finite) {
    const Eigen::Vector3f low = tree_m(low_world_m), high = tree_m(high_world_m);
    bool inside = steps_bound(1.001 * (high_world_m - low_world_m).norm()) < kRayStepsMax;
    for (int axis = 0; axis < 3; ++axis) inside = inside && in_cube(low[axis]) && in_cube(high[axis]);
    if (inside) return;
  }
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3d point_world_m(points[3 * i], points[3 * i + 1], points[3 * i + 2]);
    if (!point_world_m.allFinite()) continue;
    const Eigen::Vector3f point = tree_m(point_world_m);
    require_in_cube(point, "scan.points_world_m");
    const double distance_m = (point - scan.origin_m).norm();
    const double reach_m = max_range_m < 0 ? distance_m : std::min(distance_m, max_range_m);
    require(steps_bound(reach_m) < kRayStepsMax, "scan.range_m", reach_m,
            "must be less than 57,000 voxels, OctoMap's longest ray");
  }
}

Scan OccupancyMap::Impl::checked_scan(std::span<const float> points_world_m, const Eigen::Vector3d& scan_origin_world_m,
                                      double max_range_m) const {
  require(scan_origin_world_m.allFinite(), "scan.origin_world_m", scan_origin_world_m.transpose(), "must be finite");
  const Scan scan{points_world_m, tree_m(scan_origin_world_m)};
  require_in_cube(scan.origin_m, "scan.origin_world_m");
  check_points(scan, max_range_m);
  return scan;
}

OccupancyMap::Impl::Clipped OccupancyMap::Impl::clip_to_cube(std::span<const float> points_world_m,
                                                             const Eigen::Vector3d& scan_origin_world_m) const {
  const bool from_inside = !scan_origin_world_m.allFinite() || in_cube(tree_m(scan_origin_world_m));
  std::vector<std::size_t> outside;
  for (std::size_t i = 0; i < points_world_m.size(); i += 3) {
    const Eigen::Vector3d point_world_m(points_world_m[i], points_world_m[i + 1], points_world_m[i + 2]);
    if (point_world_m.allFinite() && !(from_inside && in_cube(tree_m(point_world_m)))) outside.push_back(i);
  }
  Clipped clipped{{}, outside.size()};
  if (outside.empty() || !from_inside) return clipped;
  std::size_t next = 0;
  for (std::size_t i = 0; i < points_world_m.size(); i += 3) {
    if (next < outside.size() && outside[next] == i) {
      ++next;
    } else {
      for (std::size_t axis = 0; axis < 3; ++axis) clipped.inside_world_m.push_back(points_world_m[i + axis]);
    }
  }
  return clipped;
}

void OccupancyMap::insert_scan(std::span<const float> points_world_m, const Eigen::Vector3d& origin_world_m,
                               double max_range_m) {
  require(points_world_m.size() % 3 == 0, "scan.points_world_m.size", points_world_m.size(), "must be rows of x, y, z");
  const std::int64_t count = static_cast<std::int64_t>(points_world_m.size() / 3);
  insert_scans(points_world_m, {&count, 1}, {origin_world_m.data(), 3}, max_range_m, 1);
}

void OccupancyMap::insert_scans(std::span<const float> points_world_m, std::span<const std::int64_t> counts,
                                std::span<const double> origins_world_m, double max_range_m, int threads) {
  require(threads >= 1 && threads <= kThreadsMax, "threads", threads, "must be in [1, 1024]");
  require(origins_world_m.size() == 3 * counts.size(), "scans.origins_world_m.size", origins_world_m.size(),
          "must be x, y, z for each count");
  const double range_m = octomap_range_m(max_range_m);
  std::vector<Scan> scans;
  scans.reserve(counts.size());
  std::vector<std::vector<float>> clipped_points;  // of the scans that are partly outside
  std::uint64_t outside = 0;
  std::size_t at = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    require(counts[i] >= 0 && static_cast<std::size_t>(counts[i]) <= points_world_m.size() / 3 - at,
            "scans.counts[" + std::to_string(i) + "]", counts[i], "must add up to the number of points");
    const auto count = static_cast<std::size_t>(counts[i]);
    std::span<const float> points = points_world_m.subspan(3 * at, 3 * count);
    Eigen::Vector3d origin(origins_world_m.data() + 3 * i);
    at += count;
    if (impl_->options.on_outside == OnOutside::count) {
      Impl::Clipped clipped = impl_->clip_to_cube(points, origin);
      outside += clipped.outside;
      if (clipped.outside > 0 && clipped.inside_world_m.empty()) continue;
      if (clipped.outside > 0) points = clipped_points.emplace_back(std::move(clipped.inside_world_m));
    }
    scans.push_back(impl_->checked_scan(points, origin, range_m));
  }
  require(3 * at == points_world_m.size(), "scans.counts", at, "must add up to the number of points");
  const std::scoped_lock lock(impl_->mutex);
  impl_->engine->insert(scans, range_m, threads);
  impl_->outside_points += outside;
}

}  // namespace uwsim
