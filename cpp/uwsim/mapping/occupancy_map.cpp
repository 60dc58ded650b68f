#include "uwsim/mapping/occupancy_map.h"

#include <unistd.h>

#include <bit>
#include <sstream>
#include <string>

#include "uwsim/core/check.h"
#include "uwsim/mapping/atomic_file.h"
#include "uwsim/mapping/bricks/brick_engine.h"
#include "uwsim/mapping/morton.h"
#include "uwsim/mapping/occupancy_map_impl.h"
#include "uwsim/mapping/octomap_engine.h"

namespace uwsim {
namespace {

constexpr std::uint64_t kListedVoxelsMax = 100'000'000;

/// Visits the voxels of a leaf in Morton order, so that a list of voxels does not depend on pruning.
template <typename Visit>
void for_each_voxel(const VoxelKey& corner, int levels, const Visit& visit) {
  if (levels == 0) return visit(corner);
  for (int i = 0; i < 8; ++i) for_each_voxel(child_corner(corner, i, 1 << (levels - 1)), levels - 1, visit);
}

/// Refuses a map that is too large before memory is allocated: a file of a few bytes per chunk may need a thousand
/// times its size in memory.
void require_memory_for(const OctreeFile& file, std::string_view name, const MapOptions& options) {
  constexpr double kChunkBytes = 2'200, kFullBrickBytes = 2'240, kOctomapNodeBytes = 100;
  const auto inner_nodes = [&](int levels) {
    return static_cast<double>(file.inner_nodes[std::size_t(kTreeDepth - levels)]);
  };
  const double needed = options.engine == MapEngineKind::octomap
                            ? static_cast<double>(file.nodes) * kOctomapNodeBytes
                            : inner_nodes(6) * kChunkBytes + inner_nodes(3) * kFullBrickBytes;
  const double available =
      static_cast<double>(::sysconf(_SC_PHYS_PAGES)) * static_cast<double>(::sysconf(_SC_PAGESIZE));
  require(needed <= available / 2, "map '" + std::string(name) + "': memory",
          std::to_string(static_cast<std::uint64_t>(needed / 1e6)) + " MB",
          "may be needed, more than half of what this machine has");
}

}  // namespace

std::unique_ptr<MapEngine> OccupancyMap::Impl::make_engine(double resolution_m, const Eigen::Vector3d& origin_world_m,
                                                           const MapOptions& options) {
  if (options.engine == MapEngineKind::octomap) {
    return make_octomap_engine(resolution_m, origin_world_m, options.model);
  }
  return make_brick_engine(resolution_m, origin_world_m, options.model, options.instruction_set);
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
  impl_ = std::make_unique<Impl>(resolution_m, origin_world_m, options);
}

OccupancyMap::~OccupancyMap() = default;
OccupancyMap::OccupancyMap(OccupancyMap&&) noexcept = default;
OccupancyMap& OccupancyMap::operator=(OccupancyMap&&) noexcept = default;

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

template <typename Visit>
void OccupancyMap::Impl::for_each_voxel_that_is(bool occupied, const Visit& visit) const {
  const ChangedChunks chunks = occupied ? engine->occupied_chunks() : ChangedChunks{true, {}};
  if (chunks.all) {
    return engine->for_each_leaf([&](const VoxelKey& corner, int levels, float log_odds) {
      if (is_occupied(log_odds) == occupied) for_each_voxel(corner, levels, visit);
    });
  }
  // About ten times as fast as visiting every leaf, since most voxels are free
  for (const std::uint32_t chunk : chunks.codes) {
    OccupiedWords words{};
    engine->occupied_in(chunk, words);
    for (std::size_t word = 0; word < words.size(); ++word) {
      for (std::uint64_t bits = words[word]; bits != 0; bits &= bits - 1) {
        visit(morton::key(std::uint64_t{chunk} << 18 | word << 6 | static_cast<std::uint64_t>(std::countr_zero(bits))));
      }
    }
  }
}

std::vector<double> OccupancyMap::Impl::voxels_world_m(bool occupied) const {
  const std::scoped_lock lock(mutex);
  const VoxelCounts counted = engine->count();
  const std::uint64_t voxels = occupied ? counted.occupied : counted.free;
  require(voxels <= kListedVoxelsMax, occupied ? "map.occupied_voxels" : "map.free_voxels", voxels,
          "too many to list (100 million at most): ask state_at for those of interest");
  std::vector<double> centres;
  centres.reserve(3 * voxels);
  for_each_voxel_that_is(occupied, [&](const VoxelKey& key) {
    for (std::size_t axis = 0; axis < 3; ++axis) centres.push_back(centre_world_m(key, 0, axis));
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
  write_file_atomically(path, to_bytes(format));
}

std::shared_ptr<octomap::OcTree> OccupancyMap::octree() const {
  const std::scoped_lock lock(impl_->mutex);
  return octree_of(impl_->engine->full_tree(), impl_->resolution_m, impl_->options.model);
}

}  // namespace uwsim
