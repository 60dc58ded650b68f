#include "uwsim/mapping/occupancy_map.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <numeric>
#include <sstream>

#include "uwsim/core/check.h"
#include "uwsim/mapping/atomic_file.h"
#include "uwsim/mapping/brick_engine.h"
#include "uwsim/mapping/occupancy_map_impl.h"
#include "uwsim/mapping/octomap_engine.h"

namespace uwsim {
namespace {

/// OctoMap collects a ray's keys in a buffer of 100,000, and its assertions are on: past it the process ends.
constexpr double kRayStepsMax = 99'990;
constexpr double kMaxRangeMin_m = 1e-9;  // OctoMap may not end a walk shorter than floats can tell
constexpr std::uint64_t kListedVoxelsMax = 100'000'000;
constexpr int kThreadsMax = 1024;

/// The voxels of a leaf in Morton order, so that a list of voxels does not depend on what was pruned.
template <typename Visit>
void for_each_voxel(const VoxelKey& key, int levels, const Visit& visit) {
  if (levels == 0) return visit(key);
  const int half = 1 << (levels - 1);
  for (int child = 0; child < 8; ++child) {
    for_each_voxel({key[0] + (child & 1) * half, key[1] + (child >> 1 & 1) * half, key[2] + (child >> 2 & 1) * half},
                   levels - 1, visit);
  }
}

}  // namespace

std::unique_ptr<MapEngine> OccupancyMap::Impl::make_engine(double resolution_m, const Eigen::Vector3d& origin_world_m,
                                                           const MapOptions& options) {
  if (options.engine == MapEngineKind::octomap) {
    return make_octomap_engine(resolution_m, origin_world_m, options.model);
  }
  return make_brick_engine(resolution_m, origin_world_m, options.model, options.instruction_set,
                           options.memory_limit_bytes, options.spill_folder);
}

void OccupancyMap::Impl::require_in_cube(const Eigen::Vector3f& tree_m, const char* path) const {
  if (in_cube(tree_m)) return;
  std::ostringstream rule;
  rule << "must be within " << (kHalfExtent - 1) * resolution_m
       << " m of map.origin_world_m = " << origin_world_m.transpose() << " along each axis";
  require(false, path, (tree_m.cast<double>() + origin_world_m).transpose(), rule.str());
}

OccupancyMap::OccupancyMap(double resolution_m, const Eigen::Vector3d& origin_world_m, const MapOptions& options) {
  require_resolution(resolution_m, "map.resolution_m");
  require(origin_world_m.allFinite(), "map.origin_world_m", origin_world_m.transpose(), "must be finite");
  options.model.check();
  require(options.memory_limit_bytes == 0 || options.engine == MapEngineKind::bricks, "map.memory_limit_mb",
          static_cast<double>(options.memory_limit_bytes) / 1e6, "only engine 'bricks' can hold to a limit of memory");
  impl_ = std::make_unique<Impl>(resolution_m, origin_world_m, options);
}

OccupancyMap::~OccupancyMap() = default;
OccupancyMap::OccupancyMap(OccupancyMap&&) noexcept = default;
OccupancyMap& OccupancyMap::operator=(OccupancyMap&&) noexcept = default;

namespace {

/// A file of a few bytes a chunk may ask for a thousand times as much memory: such a map is refused before it takes it.
void require_memory_for(const OctreeFile& file, std::string_view name, const MapOptions& options) {
  if (options.memory_limit_bytes > 0) return;
  constexpr double kChunkBytes = 2'200, kFullBrickBytes = 2'240, kOctomapNodeBytes = 100;
  const auto inner = [&](int levels) {
    return static_cast<double>(file.inner_nodes[std::size_t(kTreeDepth - levels)]);
  };
  const double needed = options.engine == MapEngineKind::octomap ? static_cast<double>(file.nodes) * kOctomapNodeBytes
                                                                 : inner(6) * kChunkBytes + inner(3) * kFullBrickBytes;
  const double there = static_cast<double>(::sysconf(_SC_PHYS_PAGES)) * static_cast<double>(::sysconf(_SC_PAGESIZE));
  require(needed <= there / 2, "map '" + std::string(name) + "': memory",
          std::to_string(static_cast<std::uint64_t>(needed / 1e6)) + " MB",
          "may be needed, more than half of what this machine has; read it with a memory_limit_mb");
}

}  // namespace

OccupancyMap OccupancyMap::from_bytes(std::string_view bytes, std::string_view name,
                                      const Eigen::Vector3d& origin_world_m, const MapOptions& options) {
  const OctreeFile file = check_octree_file(bytes, name);
  require_memory_for(file, name, options);
  OccupancyMap map(file.resolution_m, origin_world_m, options);
  if (file.nodes > 0) map.impl_->engine->load(file.format, bytes.substr(file.body_offset));
  return map;
}

OccupancyMap OccupancyMap::read(const std::string& path, const Eigen::Vector3d& origin_world_m,
                                const MapOptions& options) {
  return from_bytes(read_whole_file(path), path, origin_world_m, options);
}

double OccupancyMap::resolution_m() const { return impl_->resolution_m; }
Eigen::Vector3d OccupancyMap::origin_world_m() const { return impl_->origin_world_m; }
MapEngineKind OccupancyMap::engine() const { return impl_->options.engine; }

/// Every point where it can be inserted, none past OctoMap's longest ray. Only a box that is too large calls for a look
/// at each point.
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

Scan OccupancyMap::Impl::checked(std::span<const float> points_world_m, const Eigen::Vector3d& scan_origin_world_m,
                                 double max_range_m) const {
  require(scan_origin_world_m.allFinite(), "scan.origin_world_m", scan_origin_world_m.transpose(), "must be finite");
  const Scan scan{points_world_m, tree_m(scan_origin_world_m)};
  require_in_cube(scan.origin_m, "scan.origin_world_m");
  check_points(scan, max_range_m);
  return scan;
}

std::pair<std::vector<float>, std::uint64_t> OccupancyMap::Impl::inside(
    std::span<const float> points_world_m, const Eigen::Vector3d& scan_origin_world_m) const {
  std::pair<std::vector<float>, std::uint64_t> found{{}, 0};
  const bool from_inside = !scan_origin_world_m.allFinite() || in_cube(tree_m(scan_origin_world_m));
  std::vector<std::size_t> lost;
  for (std::size_t i = 0; i < points_world_m.size(); i += 3) {
    const Eigen::Vector3d point_world_m(points_world_m[i], points_world_m[i + 1], points_world_m[i + 2]);
    if (point_world_m.allFinite() && !(from_inside && in_cube(tree_m(point_world_m)))) lost.push_back(i);
  }
  found.second = lost.size();
  if (lost.empty() || !from_inside) return found;
  std::size_t next = 0;
  for (std::size_t i = 0; i < points_world_m.size(); i += 3) {
    if (next < lost.size() && lost[next] == i) {
      ++next;
    } else {
      for (std::size_t axis = 0; axis < 3; ++axis) found.first.push_back(points_world_m[i + axis]);
    }
  }
  return found;
}

void OccupancyMap::Impl::insert(std::span<const Scan> scans, double max_range_m, int threads) {
  const std::scoped_lock lock(mutex);
  engine->insert(scans, max_range_m, threads);
}

namespace {

/// As OctoMap has it: negative for no limit.
double octomap_range_m(double max_range_m) {
  require(max_range_m >= kMaxRangeMin_m, "scan.max_range_m", max_range_m,
          "must be positive, and a nanometre at least (infinity: no limit)");
  return std::isinf(max_range_m) ? -1.0 : max_range_m;
}

}  // namespace

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
  std::vector<std::vector<float>> kept;  // the points of scans of which some lie outside
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
      auto [inside, lost] = impl_->inside(points, origin);
      outside += lost;
      if (lost > 0 && inside.empty()) continue;
      if (lost > 0) points = kept.emplace_back(std::move(inside));
    }
    scans.push_back(impl_->checked(points, origin, range_m));
  }
  require(3 * at == points_world_m.size(), "scans.counts", at, "must add up to the number of points");
  impl_->insert(scans, range_m, threads);
  const std::scoped_lock lock(impl_->mutex);
  impl_->outside_points += outside;
}

std::uint64_t OccupancyMap::Impl::count(bool occupied) const {
  std::uint64_t voxels = 0;
  engine->for_each_leaf([&](const VoxelKey&, int levels, float log_odds) {
    if (OccupancyModel::is_occupied(log_odds) == occupied) voxels += std::uint64_t{1} << (3 * levels);
  });
  return voxels;
}

std::vector<double> OccupancyMap::Impl::voxels_world_m(bool occupied) const {
  const std::scoped_lock lock(mutex);
  const std::uint64_t voxels = count(occupied);
  require(voxels <= kListedVoxelsMax, occupied ? "map.occupied_voxels" : "map.free_voxels", voxels,
          "too many to list (100 million at most): ask state_at for those of interest");
  std::vector<double> centres;
  centres.reserve(3 * voxels);
  engine->for_each_leaf([&](const VoxelKey& corner, int levels, float log_odds) {
    if (OccupancyModel::is_occupied(log_odds) != occupied) return;
    for_each_voxel(corner, levels, [&](const VoxelKey& key) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        centres.push_back(centre_world_m(key, 0, axis));
      }
    });
  });
  return centres;
}

std::vector<double> OccupancyMap::occupied_voxels_world_m() const { return impl_->voxels_world_m(true); }
std::vector<double> OccupancyMap::free_voxels_world_m() const { return impl_->voxels_world_m(false); }

std::string OccupancyMap::to_bytes(MapFormat format) const {
  const std::scoped_lock lock(impl_->mutex);
  const TreeBytes tree = format == MapFormat::bt ? impl_->engine->binary_tree() : impl_->engine->full_tree();
  return octree_header(format, tree.nodes, impl_->resolution_m) + tree.body;
}

void OccupancyMap::write(const std::string& path, MapFormat format) const {
  AtomicFile file(path);
  const std::scoped_lock lock(impl_->mutex);
  impl_->engine->write_tree(format, file);
  file.commit();
}

std::shared_ptr<octomap::OcTree> OccupancyMap::octree() const {
  const std::scoped_lock lock(impl_->mutex);
  return octree_of(impl_->engine->full_tree(), impl_->resolution_m, impl_->options.model);
}

}  // namespace uwsim
