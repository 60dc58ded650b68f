#include "uwsim/mapping/occupancy_map.h"

#include <octomap/OcTree.h>

#include <array>
#include <cmath>
#include <mutex>
#include <sstream>

#include "uwsim/core/check.h"
#include "uwsim/mapping/atomic_file.h"

// The tree's code is Debian's own, linked from its archives: compiled here, it could give another tree.
extern template class octomap::OcTreeDataNode<float>;
extern template class octomap::OcTreeBaseImpl<octomap::OcTreeNode, octomap::AbstractOccupancyOcTree>;
extern template class octomap::OccupancyOcTreeBase<octomap::OcTreeNode>;

namespace uwsim {
namespace {

using octomap::OcTreeNode;

constexpr int kHalfExtent = 1 << (kTreeDepth - 1);
/// OctoMap collects a ray's keys in a buffer of 100,000, and its assertions are on: past it the process ends.
constexpr double kRayStepsMax = 99'990;
constexpr std::uint64_t kListedVoxelsMax = 100'000'000;
/// Inner nodes are left alone while scans come in (lazy), which is the faster the finer the voxels; past this many
/// nodes the tree is pruned each time it has doubled, which bounds the memory.
constexpr std::size_t kLazyNodes = 16'000'000;

/// Bits of a child in a .bt.
enum Code : unsigned { kUnknown = 0, kFree = 1, kOccupied = 2, kInner = 3 };

/// The protected members, without OctoMap's accessors and iterators, which Debian's archives do not export.
struct Children : OcTreeNode {
  static const OcTreeNode* at(const OcTreeNode& node, int child) {
    octomap::AbstractOcTreeNode** all = node.*(&Children::children);
    return all ? static_cast<const OcTreeNode*>(all[child]) : nullptr;
  }
  static bool none(const OcTreeNode& node) { return node.*(&Children::children) == nullptr; }
};
struct Root : octomap::OcTree {
  /// Null in an empty tree.
  static OcTreeNode* of(const octomap::OcTree& tree) { return tree.*(&Root::root); }
};

/// Prunes and refreshes the inner nodes bottom up, as an eager insertion would have left them. The root stays: a .bt
/// says nothing of a root that is a leaf.
void settle(octomap::OcTree& tree, OcTreeNode& node) {
  if (Children::none(node)) return;
  for (int child = 0; child < 8; ++child) {
    if (const OcTreeNode* below = Children::at(node, child)) settle(tree, const_cast<OcTreeNode&>(*below));
  }
  if (&node == Root::of(tree) || !tree.pruneNode(&node)) node.updateOccupancyChildren();
}

/// Writes the maximum likelihood tree in preorder without touching the live one: eight equal children become one leaf.
/// OctoMap's writeBinary rounds the live tree off and prints to stderr in Debian's build, whose archives export neither
/// its node writer nor a copy constructor. The tests hold these bytes against writeBinary's.
class BinaryWriter {
 public:
  explicit BinaryWriter(const octomap::OcTree& tree) : tree_(tree) {}

  Code write(const OcTreeNode& node) {
    ++nodes;
    if (Children::none(node)) return tree_.isNodeOccupied(node) ? kOccupied : kFree;
    const std::size_t at = body.size();
    const std::uint64_t nodes_before = nodes;
    body.append(2, '\0');
    unsigned codes = 0;
    for (int child = 0; child < 8; ++child) {
      if (const OcTreeNode* below = Children::at(node, child)) codes |= write(*below) << (2 * child);
    }
    for (const Code whole : {kFree, kOccupied}) {
      if (codes != whole * 0x5555u || &node == Root::of(tree_)) continue;
      body.resize(at);
      nodes = nodes_before;
      return whole;
    }
    body[at] = static_cast<char>(codes & 0xff);
    body[at + 1] = static_cast<char>(codes >> 8);
    return kInner;
  }

  std::string body;
  std::uint64_t nodes = 0;

 private:
  const octomap::OcTree& tree_;
};

using Key = std::array<int, 3>;

/// The lowest corner of a child, from that of its parent, which is two halves wide.
Key child_corner(const Key& corner, int child, int half) {
  return {corner[0] + (child & 1) * half, corner[1] + (child >> 1 & 1) * half, corner[2] + (child >> 2 & 1) * half};
}

/// Calls visit(leaf, key, levels) for each leaf in Morton order: `levels` above the finest, `key` its lowest corner.
template <typename Visit>
void for_each_leaf(const OcTreeNode& node, const Key& key, int levels, const Visit& visit) {
  if (Children::none(node)) return visit(node, key, levels);
  const int half = 1 << (levels - 1);
  for (int child = 0; child < 8; ++child) {
    const OcTreeNode* below = Children::at(node, child);
    if (below) for_each_leaf(*below, child_corner(key, child, half), levels - 1, visit);
  }
}

/// The same order inside a pruned leaf, so that a list of voxels does not depend on what was pruned.
template <typename Visit>
void for_each_voxel(const Key& key, int levels, const Visit& visit) {
  if (levels == 0) return visit(key);
  const int half = 1 << (levels - 1);
  for (int child = 0; child < 8; ++child) for_each_voxel(child_corner(key, child, half), levels - 1, visit);
}

}  // namespace

struct OccupancyMap::Impl {
  Impl(double resolution, const Eigen::Vector3d& origin)
      : resolution_m(resolution), origin_world_m(origin), tree(std::make_unique<octomap::OcTree>(resolution)) {}

  void settle_now() {
    if (OcTreeNode* root = Root::of(*tree); root && !settled) settle(*tree, *root);
    settled = true;
  }

  /// Voxels from OctoMap's origin along an axis, as OctoMap itself reckons it.
  double cell(double tree_m) const { return std::floor(1.0 / resolution_m * tree_m); }

  /// Within the cube, less its outermost voxels: a ray along the very edge could step over it.
  void require_in_cube(const Eigen::Vector3f& tree_m, const char* path) const {
    const auto reach = tree_m.unaryExpr([this](float x) { return std::abs(cell(x) + 0.5); });
    if (reach.maxCoeff() < kHalfExtent - 1) return;
    std::ostringstream rule;
    rule << "must be within " << (kHalfExtent - 1) * resolution_m
         << " m of map.origin_world_m = " << origin_world_m.transpose() << " along each axis";
    require(false, path, (tree_m.cast<double>() + origin_world_m).transpose(), rule.str());
  }

  octomap::Pointcloud cloud(std::span<const float> points_world_m, const Eigen::Vector3f& origin,
                            double max_range_m) const;
  std::uint64_t count(bool occupied) const;
  std::vector<double> voxels_world_m(bool occupied) const;

  const double resolution_m;
  const Eigen::Vector3d origin_world_m;
  std::unique_ptr<octomap::OcTree> tree;
  bool settled = true;
  std::size_t lazy_nodes = kLazyNodes;
  mutable std::mutex mutex;
};

OccupancyMap::OccupancyMap(double resolution_m, const Eigen::Vector3d& origin_world_m) {
  require_resolution(resolution_m, "map.resolution_m");
  require(origin_world_m.allFinite(), "map.origin_world_m", origin_world_m.transpose(), "must be finite");
  impl_ = std::make_unique<Impl>(resolution_m, origin_world_m);
}

OccupancyMap::~OccupancyMap() = default;
OccupancyMap::OccupancyMap(OccupancyMap&&) noexcept = default;
OccupancyMap& OccupancyMap::operator=(OccupancyMap&&) noexcept = default;

OccupancyMap OccupancyMap::from_bytes(std::string_view bytes, std::string_view name,
                                      const Eigen::Vector3d& origin_world_m) {
  const OctreeFile file = check_octree_file(bytes, name);
  OccupancyMap map(file.resolution_m, origin_world_m);
  if (file.nodes == 0) return map;
  std::istringstream body{std::string(bytes.substr(file.body_offset))};
  octomap::OcTree& tree = *map.impl_->tree;
  file.format == MapFormat::bt ? tree.readBinaryData(body) : tree.readData(body);  // proved above: neither can fail
  map.impl_->settled = false;
  return map;
}

OccupancyMap OccupancyMap::read(const std::string& path, const Eigen::Vector3d& origin_world_m) {
  return from_bytes(read_whole_file(path), path, origin_world_m);
}

double OccupancyMap::resolution_m() const { return impl_->resolution_m; }
Eigen::Vector3d OccupancyMap::origin_world_m() const { return impl_->origin_world_m; }

/// The points as the tree takes them, every one of them where it can be inserted.
octomap::Pointcloud OccupancyMap::Impl::cloud(std::span<const float> points_world_m, const Eigen::Vector3f& origin,
                                              double max_range_m) const {
  octomap::Pointcloud cloud;
  cloud.reserve(points_world_m.size() / 3);
  for (std::size_t i = 0; i < points_world_m.size(); i += 3) {
    const Eigen::Vector3d point_world_m(points_world_m[i], points_world_m[i + 1], points_world_m[i + 2]);
    if (!point_world_m.allFinite()) continue;
    const Eigen::Vector3f point = (point_world_m - origin_world_m).cast<float>();
    require_in_cube(point, "scan.points_world_m");
    const double reach_m = std::min<double>((point - origin).norm(), max_range_m);
    require(std::sqrt(3.0) * reach_m / resolution_m < kRayStepsMax, "scan.range_m", reach_m,
            "must be less than 57,000 voxels, OctoMap's longest ray");
    cloud.push_back(point.x(), point.y(), point.z());
  }
  return cloud;
}

void OccupancyMap::insert_scan(std::span<const float> points_world_m, const Eigen::Vector3d& origin_world_m,
                               double max_range_m) {
  require(points_world_m.size() % 3 == 0, "scan.points_world_m.size", points_world_m.size(), "must be rows of x, y, z");
  require(origin_world_m.allFinite(), "scan.origin_world_m", origin_world_m.transpose(), "must be finite");
  require(max_range_m > 0, "scan.max_range_m", max_range_m, "must be positive (infinity: no limit)");
  const std::scoped_lock lock(impl_->mutex);
  const Eigen::Vector3f origin = (origin_world_m - impl_->origin_world_m).cast<float>();
  impl_->require_in_cube(origin, "scan.origin_world_m");

  const octomap::Pointcloud cloud = impl_->cloud(points_world_m, origin, max_range_m);
  octomap::OcTree& tree = *impl_->tree;
  constexpr bool kLazy = true;
  tree.insertPointCloud(cloud, {origin.x(), origin.y(), origin.z()}, std::isinf(max_range_m) ? -1.0 : max_range_m,
                        kLazy);
  impl_->settled = false;
  if (tree.size() > impl_->lazy_nodes) {
    impl_->settle_now();
    impl_->lazy_nodes = std::max(kLazyNodes, 2 * tree.size());
  }
}

std::uint64_t OccupancyMap::Impl::count(bool occupied) const {
  std::uint64_t voxels = 0;
  const OcTreeNode* root = Root::of(*tree);
  if (!root) return voxels;
  for_each_leaf(*root, {}, kTreeDepth, [&](const OcTreeNode& leaf, const Key&, int levels) {
    if (tree->isNodeOccupied(leaf) == occupied) voxels += std::uint64_t{1} << (3 * levels);
  });
  return voxels;
}

std::vector<double> OccupancyMap::Impl::voxels_world_m(bool occupied) const {
  const std::scoped_lock lock(mutex);
  const std::uint64_t voxels = count(occupied);
  require(voxels <= kListedVoxelsMax, occupied ? "map.occupied_voxels" : "map.free_voxels", voxels,
          "too many to list (100 million at most): ask state_at for those of interest");
  std::vector<double> centres;
  if (voxels == 0) return centres;
  centres.reserve(3 * voxels);
  for_each_leaf(*Root::of(*tree), {}, kTreeDepth, [&](const OcTreeNode& leaf, const Key& corner, int levels) {
    if (tree->isNodeOccupied(leaf) != occupied) return;
    for_each_voxel(corner, levels, [&](const Key& key) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        centres.push_back((key[axis] - kHalfExtent + 0.5) * resolution_m + origin_world_m[Eigen::Index(axis)]);
      }
    });
  });
  return centres;
}

std::vector<double> OccupancyMap::occupied_voxels_world_m() const { return impl_->voxels_world_m(true); }
std::vector<double> OccupancyMap::free_voxels_world_m() const { return impl_->voxels_world_m(false); }

MapStatistics OccupancyMap::statistics() const {
  const std::scoped_lock lock(impl_->mutex);
  impl_->settle_now();
  return {impl_->count(true), impl_->count(false), impl_->tree->size(), impl_->tree->memoryUsage()};
}

std::vector<std::int8_t> OccupancyMap::state_at(std::span<const double> points_world_m) const {
  require(points_world_m.size() % 3 == 0, "points_world_m.size", points_world_m.size(), "must be rows of x, y, z");
  for (const double x : points_world_m) require(std::isfinite(x), "points_world_m", x, "must be finite");
  const std::scoped_lock lock(impl_->mutex);
  std::vector<std::int8_t> states(points_world_m.size() / 3, -1);
  for (std::size_t i = 0; i < states.size(); ++i) {
    octomap::OcTreeKey key;
    bool inside = true;
    for (unsigned axis = 0; axis < 3; ++axis) {
      const double cell = impl_->cell(points_world_m[3 * i + axis] - impl_->origin_world_m[axis]) + kHalfExtent;
      inside = inside && cell >= 0 && cell < 2 * kHalfExtent;
      if (inside) key[axis] = static_cast<octomap::key_type>(cell);
    }
    const OcTreeNode* node = inside ? impl_->tree->search(key, 0) : nullptr;
    if (node) states[i] = impl_->tree->isNodeOccupied(node) ? 1 : 0;
  }
  return states;
}

std::string OccupancyMap::to_bytes(MapFormat format) const {
  const std::scoped_lock lock(impl_->mutex);
  const octomap::OcTree& tree = *impl_->tree;
  if (format == MapFormat::bt) {
    BinaryWriter writer(tree);
    if (const OcTreeNode* root = Root::of(tree)) writer.write(*root);
    return octree_header(format, writer.nodes, impl_->resolution_m) + writer.body;
  }
  impl_->settle_now();
  std::ostringstream body;
  tree.writeData(body);
  return octree_header(format, tree.size(), impl_->resolution_m) + body.str();
}

void OccupancyMap::write(const std::string& path, MapFormat format) const {
  write_file_atomically(path, to_bytes(format));
}

}  // namespace uwsim
