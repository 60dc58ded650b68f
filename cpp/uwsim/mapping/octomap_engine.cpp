#include "uwsim/mapping/octomap_engine.h"

#include <octomap/OcTree.h>

#include <algorithm>
#include <sstream>
#include <utility>

#include "uwsim/mapping/log_odds.h"
#include "uwsim/mapping/morton.h"
#include "uwsim/mapping/quiet_stderr.h"

// These keep the tree's code from being compiled here, which might produce a different tree; it is linked from Debian's
// static libraries instead.
extern template class octomap::OcTreeDataNode<float>;
extern template class octomap::OcTreeBaseImpl<octomap::OcTreeNode, octomap::AbstractOccupancyOcTree>;
extern template class octomap::OccupancyOcTreeBase<octomap::OcTreeNode>;

namespace uwsim {
namespace {

using octomap::OcTreeNode;

/// Provides access to protected members, because OctoMap's own accessors and iterators are not in Debian's static
/// libraries.
struct Children : OcTreeNode {
  static const OcTreeNode* at(const OcTreeNode& node, int child) {
    octomap::AbstractOcTreeNode** all = node.*(&Children::children);
    return all ? static_cast<const OcTreeNode*>(all[child]) : nullptr;
  }
  static bool none(const OcTreeNode& node) { return node.*(&Children::children) == nullptr; }
};
struct Root : octomap::OcTree {
  /// The root of a tree; null if the tree is empty.
  static OcTreeNode* of(const octomap::OcTree& tree) { return tree.*(&Root::root); }
  static void make(octomap::OcTree& tree) {
    tree.*(&Root::root) = new OcTreeNode();
    ++(tree.*(&Root::tree_size));
  }
  /// OctoMap's own change detection.
  static octomap::KeyBoolMap& changed(octomap::OcTree& tree) { return tree.*(&Root::changed_keys); }
  static void detect_changes(octomap::OcTree& tree) { tree.*(&Root::use_change_detection) = true; }
};

/// Updates and prunes the inner nodes from the bottom up, to the state that insertions would have produced. The root is
/// not pruned, since a .bt cannot express a root that is a leaf.
void update_inner_nodes(octomap::OcTree& tree, OcTreeNode& node) {
  if (Children::none(node)) return;
  for (int child = 0; child < 8; ++child) {
    if (const OcTreeNode* below = Children::at(node, child)) update_inner_nodes(tree, const_cast<OcTreeNode&>(*below));
  }
  if (&node == Root::of(tree) || !tree.pruneNode(&node)) node.updateOccupancyChildren();
}

/// Adds to all voxels below a node, known or not.
void add_to_all(octomap::OcTree& tree, OcTreeNode& node, float log_odds) {
  if (Children::none(node)) return tree.updateNodeLogOdds(&node, log_odds);
  for (int child = 0; child < 8; ++child) {
    if (const OcTreeNode* below = Children::at(node, child)) {
      add_to_all(tree, const_cast<OcTreeNode&>(*below), log_odds);
    } else {
      tree.updateNodeLogOdds(tree.createNodeChild(&node, static_cast<unsigned>(child)), log_odds);
    }
  }
}

/// Descends from a node with an edge of 2^at voxels to the cube of 2^levels voxels with this corner.
void add_to_cube(octomap::OcTree& tree, OcTreeNode& node, bool is_new, int at, const VoxelKey& corner, int levels,
                 float log_odds) {
  if (at == levels) return add_to_all(tree, node, log_odds);
  if (Children::none(node) && !is_new) tree.expandNode(&node);
  unsigned child = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) child |= unsigned(corner[axis] >> (at - 1) & 1) << axis;
  const OcTreeNode* below = Children::at(node, static_cast<int>(child));
  OcTreeNode& next = below ? const_cast<OcTreeNode&>(*below) : *tree.createNodeChild(&node, child);
  add_to_cube(tree, next, !below, at - 1, corner, levels, log_odds);
}

void visit_leaves_in(const OcTreeNode& node, const VoxelKey& key, int levels, const KeyBox& box,
                     const MapEngine::LeafVisitor& leaf) {
  if (!box.meets(key, levels)) return;
  if (Children::none(node)) return leaf(key, levels, node.getLogOdds());
  const int half = 1 << (levels - 1);
  for (int child = 0; child < 8; ++child) {
    const OcTreeNode* below = Children::at(node, child);
    if (below) visit_leaves_in(*below, child_corner(key, child, half), levels - 1, box, leaf);
  }
}

void visit_leaves(const OcTreeNode& node, const VoxelKey& key, int levels, const MapEngine::LeafVisitor& leaf) {
  if (Children::none(node)) return leaf(key, levels, node.getLogOdds());
  const int half = 1 << (levels - 1);
  for (int child = 0; child < 8; ++child) {
    const OcTreeNode* below = Children::at(node, child);
    if (below) visit_leaves(*below, child_corner(key, child, half), levels - 1, leaf);
  }
}

void set_model(octomap::OcTree& tree, const OccupancyModel& model) {
  tree.setProbHit(model.hit);
  tree.setProbMiss(model.miss);
  tree.setClampingThresMin(model.clamping_min);
  tree.setClampingThresMax(model.clamping_max);
}

TreeBytes binary_data(const octomap::OcTree& tree) {
  std::ostringstream body;
  const QuietStderr quiet;  // writeBinaryData prints the number of nodes
  tree.writeBinaryData(body);
  return {body.str(), tree.size()};
}

TreeBytes full_data(const octomap::OcTree& tree) {
  std::ostringstream body;
  tree.writeData(body);
  return {body.str(), tree.size()};
}

class OctomapEngine : public MapEngine {
 public:
  OctomapEngine(double resolution_m, const Eigen::Vector3d& tree_origin_world_m, const OccupancyModel& model)
      : tree_(resolution_m), tree_origin_world_m_(tree_origin_world_m), model_(model) {
    uwsim::set_model(tree_, model);
  }

  void insert(std::span<const Scan> scans, double max_range_m, int) override {
    for (const Scan& scan : scans) {
      tree_.insertPointCloud(cloud(scan), {scan.origin_m.x(), scan.origin_m.y(), scan.origin_m.z()}, max_range_m);
    }
    // If all voxels of the cube are known and equal, the tree is pruned to a single leaf at the root, which a .bt
    // cannot express.
    if (OcTreeNode* root = Root::of(tree_); root && Children::none(*root)) tree_.expandNode(root);
  }

  void add(const VoxelKey& corner, int levels, float log_odds) override {
    changed_.add(corner, levels);
    const bool is_new = !Root::of(tree_);
    if (is_new) Root::make(tree_);
    add_to_cube(tree_, *Root::of(tree_), is_new, kTreeDepth, corner, levels, log_odds);
  }
  void finish_adding() override {
    if (OcTreeNode* root = Root::of(tree_)) update_inner_nodes(tree_, *root);
  }

  void set_model(const OccupancyModel& model) override {
    model_ = model;
    uwsim::set_model(tree_, model);
  }

  ChangedChunks take_changed() override {
    ChangedChunks changed = std::exchange(changed_, {});
    for (const auto& [key, is_created] : Root::changed(tree_)) changed.add({key[0], key[1], key[2]}, 0);
    Root::detect_changes(tree_);
    Root::changed(tree_).clear();
    return changed;
  }

  ChangedChunks occupied_chunks() const override {
    ChangedChunks chunks;
    for_each_leaf([&](const VoxelKey& corner, int levels, float log_odds) {
      if (is_occupied(log_odds)) chunks.add(corner, levels);
    });
    return chunks;
  }

  void occupied_in(std::uint32_t chunk, OccupiedWords& words) const override {
    for_each_leaf_in(chunk_box(chunk), [&](const VoxelKey& corner, int levels, float log_odds) {
      if (!is_occupied(log_odds)) return;
      const std::size_t first = levels > 6 ? 0 : morton::code(corner) & 0x3ffff;
      const std::size_t count = std::size_t{1} << (3 * std::min(levels, 6));
      for (std::size_t at = first; at < first + count; at += 64) {
        words[at >> 6] |= morton::bits_in_word(at, std::min<std::size_t>(count, 64));
      }
    });
  }

  void load(MapFormat format, std::string_view body) override {
    std::istringstream stream{std::string(body)};
    format == MapFormat::bt ? tree_.readBinaryData(stream) : tree_.readData(stream);
    if (OcTreeNode* root = Root::of(tree_)) update_inner_nodes(tree_, *root);
  }

  std::optional<float> log_odds_at(const VoxelKey& key) const override {
    const auto axis = [&](std::size_t i) { return static_cast<octomap::key_type>(key[i]); };
    const OcTreeNode* node = tree_.search(octomap::OcTreeKey(axis(0), axis(1), axis(2)), 0);
    return node ? std::optional(node->getLogOdds()) : std::nullopt;
  }

  void for_each_leaf(const LeafVisitor& leaf) const override {
    if (const OcTreeNode* root = Root::of(tree_)) visit_leaves(*root, {}, kTreeDepth, leaf);
  }

  void for_each_leaf_in(const KeyBox& box, const LeafVisitor& leaf) const override {
    if (const OcTreeNode* root = Root::of(tree_)) visit_leaves_in(*root, {}, kTreeDepth, box, leaf);
  }

  TreeBytes full_tree() const override { return full_data(tree_); }

  /// Does the same as writeBinary, but on a copy, so that the tree keeps its log-odds.
  TreeBytes binary_tree() const override { return Root::of(tree_) ? binary_data(*likely_copy()) : TreeBytes{}; }

  std::uint64_t nodes() const override { return tree_.size(); }
  std::size_t memory_bytes() const override { return tree_.memoryUsage(); }

 private:
  std::shared_ptr<octomap::OcTree> likely_copy() const {
    std::shared_ptr<octomap::OcTree> copy = octree_of(full_data(tree_), tree_.getResolution(), model_);
    copy->toMaxLikelihood();
    copy->prune();
    return copy;
  }

  /// The scan's points in the tree's frame. A point whose squared distance is 0 in float is moved to the origin,
  /// because OctoMap's walk to it might not terminate.
  octomap::Pointcloud cloud(const Scan& scan) const {
    octomap::Pointcloud cloud;
    const std::span<const float> points = scan.points_world_m;
    cloud.reserve(points.size() / 3);
    for (std::size_t i = 0; i < points.size(); i += 3) {
      const Eigen::Vector3d point_world_m(points[i], points[i + 1], points[i + 2]);
      if (!point_world_m.allFinite()) continue;
      Eigen::Vector3f point = (point_world_m - tree_origin_world_m_).cast<float>();
      const Eigen::Vector3f delta = point - scan.origin_m;
      if (delta.x() * delta.x() + delta.y() * delta.y() + delta.z() * delta.z() == 0) point = scan.origin_m;
      cloud.push_back(point.x(), point.y(), point.z());
    }
    return cloud;
  }

  octomap::OcTree tree_;
  const Eigen::Vector3d tree_origin_world_m_;
  OccupancyModel model_;
  ChangedChunks changed_{true, {}};
};

}  // namespace

std::unique_ptr<MapEngine> make_octomap_engine(double resolution_m, const Eigen::Vector3d& tree_origin_world_m,
                                               const OccupancyModel& model) {
  return std::make_unique<OctomapEngine>(resolution_m, tree_origin_world_m, model);
}

std::shared_ptr<octomap::OcTree> octree_of(const TreeBytes& full_tree, double resolution_m,
                                           const OccupancyModel& model) {
  auto tree = std::make_shared<octomap::OcTree>(resolution_m);
  set_model(*tree, model);
  if (full_tree.nodes == 0) return tree;
  std::istringstream body(full_tree.body);
  tree->readData(body);
  return tree;
}

TreeBytes written_by_octomap(const TreeBytes& binary_tree, double resolution_m, const OccupancyModel& model) {
  if (binary_tree.nodes == 0) return {};
  octomap::OcTree tree(resolution_m);
  set_model(tree, model);
  std::istringstream body(binary_tree.body);
  tree.readBinaryData(body);
  return binary_data(tree);
}

}  // namespace uwsim
