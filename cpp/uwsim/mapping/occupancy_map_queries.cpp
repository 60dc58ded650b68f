#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "uwsim/core/check.h"
#include "uwsim/mapping/map_cubes.h"
#include "uwsim/mapping/map_merge.h"
#include "uwsim/mapping/map_ray.h"
#include "uwsim/mapping/occupancy_map_impl.h"

namespace uwsim {
namespace {

constexpr std::size_t kListedMax = 100'000'000;
/// The tolerance, in voxels, for the distance between two maps' origins to be a whole number of voxels.
constexpr double kShiftTolerance = 1e-6;

void require_points(std::span<const double> points, const char* path) {
  require(points.size() % 3 == 0, std::string(path) + ".size", points.size(), "must be rows of x, y, z");
  for (const double x : points) require(std::isfinite(x), path, x, "must be finite");
}

/// Returns the direction unchanged if OctoMap can compute its length. Otherwise, returns it normalised, so that its
/// squares stay within the range of a float.
Eigen::Vector3f float_direction(const Eigen::Vector3d& direction) {
  const double length = direction.stableNorm();
  return (length > 1e18 || length < 1e-18 ? (direction / length).eval() : direction).cast<float>();
}

}  // namespace

std::optional<VoxelKey> OccupancyMap::Impl::key_at(const double* point_world_m) const {
  VoxelKey key;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double at = cell(point_world_m[axis] - origin_world_m[Eigen::Index(axis)]) + kHalfExtent;
    if (!(at >= 0 && at < 2 * kHalfExtent)) return std::nullopt;
    key[axis] = static_cast<int>(at);
  }
  return key;
}

std::optional<KeyBox> OccupancyMap::Impl::keys_in(const Eigen::Vector3d& low_world_m,
                                                  const Eigen::Vector3d& high_world_m) const {
  KeyBox box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double low = low_world_m[Eigen::Index(axis)], high = high_world_m[Eigen::Index(axis)];
    require(!std::isnan(low) && !std::isnan(high) && low <= high, "box", low,
            "the low corner must not be above the high one, nor NaN");
    const auto key = [&](double at) {
      const double voxels = cell(at - origin_world_m[Eigen::Index(axis)]);
      return static_cast<int>(std::clamp(voxels, -kHalfExtent - 1.0, kHalfExtent + 1.0)) + kHalfExtent;
    };
    const auto centre = [&](int k) { return centre_world_m({k, k, k}, 0, axis); };
    int first = std::max(key(low) - 1, 0), last = std::min(key(high) + 1, 2 * kHalfExtent - 1);
    while (first <= last && centre(first) < low) ++first;
    while (first <= last && centre(last) > high) --last;
    if (first > last) return std::nullopt;
    box.low[axis] = first;
    box.high[axis] = last;
  }
  return box;
}

MapStatistics OccupancyMap::statistics() const {
  const std::scoped_lock lock(impl_->mutex);
  const VoxelCounts voxels = impl_->engine->count();
  return {voxels.occupied, voxels.free, impl_->engine->nodes(), impl_->engine->memory_bytes(), impl_->outside_points};
}

VoxelCounts OccupancyMap::count() const {
  const std::scoped_lock lock(impl_->mutex);
  return impl_->engine->count();
}

std::optional<MapBounds> OccupancyMap::bounds() const {
  const std::scoped_lock lock(impl_->mutex);
  VoxelKey low, high;
  low.fill(std::numeric_limits<int>::max());
  high.fill(std::numeric_limits<int>::min());
  impl_->engine->for_each_leaf([&](const VoxelKey& corner, int levels, float) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], corner[axis]);
      high[axis] = std::max(high[axis], corner[axis] + (1 << levels) - 1);
    }
  });
  if (low[0] > high[0]) return std::nullopt;
  MapBounds bounds;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    bounds.low_world_m[Eigen::Index(axis)] = impl_->centre_world_m(low, 0, axis) - impl_->resolution_m / 2;
    bounds.high_world_m[Eigen::Index(axis)] = impl_->centre_world_m(high, 0, axis) + impl_->resolution_m / 2;
  }
  return bounds;
}

std::vector<float> OccupancyMap::log_odds_at(std::span<const double> points_world_m) const {
  require_points(points_world_m, "points_world_m");
  const std::scoped_lock lock(impl_->mutex);
  std::vector<float> all(points_world_m.size() / 3, std::numeric_limits<float>::quiet_NaN());
  for (std::size_t i = 0; i < all.size(); ++i) {
    const std::optional<VoxelKey> key = impl_->key_at(&points_world_m[3 * i]);
    const std::optional<float> log_odds = key ? impl_->engine->log_odds_at(*key) : std::nullopt;
    if (log_odds) all[i] = *log_odds;
  }
  return all;
}

std::vector<std::int8_t> OccupancyMap::state_at(std::span<const double> points_world_m) const {
  const std::vector<float> log_odds = log_odds_at(points_world_m);
  std::vector<std::int8_t> states(log_odds.size());
  std::transform(log_odds.begin(), log_odds.end(), states.begin(),
                 [](float x) { return std::isnan(x) ? std::int8_t{-1} : static_cast<std::int8_t>(is_occupied(x)); });
  return states;
}

namespace {

/// A visitor that appends cubes to columns.
template <typename Impl>
auto appender(MapCubes& into, const Impl& impl) {
  return [&](const MapCube& cube) {
    require(into.log_odds.size() < kListedMax, "map.cubes", into.log_odds.size(),
            "too many to list (100 million at most)");
    for (std::size_t axis = 0; axis < 3; ++axis) {
      into.centres_world_m.push_back(impl.centre_world_m(cube.corner, cube.levels, axis));
    }
    into.edges_m.push_back((1 << cube.levels) * impl.resolution_m);
    into.log_odds.push_back(cube.log_odds);
  };
}

}  // namespace

MapCubes OccupancyMap::leaves() const {
  const std::scoped_lock lock(impl_->mutex);
  MapCubes found;
  for_each_pruned_leaf(*impl_->engine, appender(found, *impl_));
  return found;
}

MapCubes OccupancyMap::cells(int depth) const {
  require(depth >= 1 && depth <= kTreeDepth, "map.depth", depth, "must be in [1, 16], of which 16 is the finest");
  const std::scoped_lock lock(impl_->mutex);
  MapCubes found;
  for_each_cell(*impl_->engine, kTreeDepth - depth, appender(found, *impl_));
  return found;
}

MapCubes OccupancyMap::voxels_in(const Eigen::Vector3d& low_world_m, const Eigen::Vector3d& high_world_m) const {
  const std::optional<KeyBox> box = impl_->keys_in(low_world_m, high_world_m);
  MapCubes found;
  if (!box) return found;
  const std::scoped_lock lock(impl_->mutex);
  for_each_voxel_in(*impl_->engine, *box, appender(found, *impl_));
  return found;
}

OccupancyMap::Casts OccupancyMap::cast_rays(std::span<const double> origins_world_m,
                                            std::span<const double> directions_world, bool ignore_unknown,
                                            double max_range_m) const {
  require_points(origins_world_m, "rays.origins_world_m");
  require_points(directions_world, "rays.directions_world");
  require(origins_world_m.size() == directions_world.size(), "rays.directions_world.size", directions_world.size(),
          "must be as many as the origins");
  require(max_range_m > 0, "rays.max_range_m", max_range_m, "must be positive (infinity: no limit)");
  const std::size_t count = origins_world_m.size() / 3;
  std::vector<Eigen::Vector3f> origins_m(count), directions(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3d origin(origins_world_m.data() + 3 * i), direction(directions_world.data() + 3 * i);
    origins_m[i] = impl_->tree_m(origin);
    impl_->require_in_cube(origins_m[i], "rays.origins_world_m");
    directions[i] = float_direction(direction);
    require(directions[i].allFinite() && directions[i] != Eigen::Vector3f::Zero(), "rays.directions_world",
            direction.transpose(), "must be finite and not zero");
  }
  Casts casts;
  casts.ends.reserve(count);
  casts.voxel_centres_world_m.reserve(3 * count);
  const double range_m = std::isinf(max_range_m) ? 0 : max_range_m;
  const std::scoped_lock lock(impl_->mutex);
  for (std::size_t i = 0; i < count; ++i) {
    const MapRayHit hit =
        cast_map_ray(*impl_->engine, impl_->resolution_m, origins_m[i], directions[i], ignore_unknown, range_m);
    casts.ends.push_back(static_cast<std::int8_t>(hit.end));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      casts.voxel_centres_world_m.push_back(impl_->centre_world_m(hit.voxel, 0, axis));
    }
  }
  return casts;
}

OccupancyMap::Changes OccupancyMap::changed_voxels() {
  const std::scoped_lock lock(impl_->mutex);
  impl_->note_changes();
  Changes changes;
  for (const MapChanges::Changed& voxel : impl_->changes.take(*impl_->engine, kListedMax)) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      changes.voxel_centres_world_m.push_back(impl_->centre_world_m(voxel.key, 0, axis));
    }
    changes.states.push_back(voxel.state);
  }
  return changes;
}

OccupancyMap::OccupancyChanges OccupancyMap::changed_occupancy() {
  const std::scoped_lock lock(impl_->mutex);
  impl_->note_changes();
  OccupancyChanges changes;
  for (const OccupiedChanges::Changed& voxel : impl_->occupied_changes.take(*impl_->engine, kListedMax)) {
    for (const int key : voxel.key) changes.cells.push_back(static_cast<std::int16_t>(key - kHalfExtent));
    changes.occupied.push_back(voxel.is_occupied);
  }
  return changes;
}

void OccupancyMap::merge(const OccupancyMap& other) {
  if (other.impl_ == impl_) throw InvalidValue("merge: a map cannot be merged with itself");
  const Impl& from = *other.impl_;
  require(from.resolution_m == impl_->resolution_m, "merge.resolution_m", from.resolution_m,
          "must be that of this map, " + std::to_string(impl_->resolution_m) + " m");
  VoxelKey shift;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const double apart = (from.origin_world_m[axis] - impl_->origin_world_m[axis]) / impl_->resolution_m;
    const double whole = std::round(apart);
    require(std::abs(apart - whole) <= kShiftTolerance, "merge.origin_world_m", from.origin_world_m.transpose(),
            "must be a whole number of voxels from this map's origin along each axis");
    require(std::abs(whole) <= 2 * kHalfExtent, "merge.origin_world_m", from.origin_world_m.transpose(),
            "must be less than 65,536 voxels from this map's origin along each axis");
    shift[std::size_t(axis)] = static_cast<int>(whole);
  }
  const std::scoped_lock lock(impl_->mutex, from.mutex);
  uwsim::merge(*impl_->engine, *from.engine, shift);
  impl_->outside_points += from.outside_points;
}

OccupancyModel OccupancyMap::model() const {
  const std::scoped_lock lock(impl_->mutex);
  return impl_->options.model;
}

void OccupancyMap::set_model(const OccupancyModel& model) {
  model.check();
  const std::scoped_lock lock(impl_->mutex);
  impl_->engine->set_model(model);
  impl_->options.model = model;
}

}  // namespace uwsim
