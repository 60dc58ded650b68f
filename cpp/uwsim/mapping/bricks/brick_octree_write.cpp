#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <string>
#include <utility>

#include "uwsim/mapping/bricks/brick_octree.h"
#include "uwsim/mapping/bricks/brick_octree_walk.h"

namespace uwsim::bricks {
namespace {

/// Writes nodes in preorder in one of OctoMap's formats (octree_file.h), or only counts them. A node precedes its
/// children in the file, but its bytes depend on theirs. The node's bytes are therefore overwritten when its children
/// are complete or, if all children are equal, the children are removed again.
class OctreeWriter {
 public:
  struct Node {
    bool exists = false;
    bool is_leaf = false;
    bool is_inserted_leaf = false;  ///< whether the node was a leaf before values were replaced by the most likely ones
    float log_odds = 0;
    float written = 0;  ///< log_odds, or the most likely value
  };
  using Counts = std::array<std::uint64_t, kTreeDepth + 1>;

  /// Writes all log-odds, as an .ot. buffer: null to count only.
  explicit OctreeWriter(std::string* buffer) : buffer_(buffer) {}
  /// Writes the most likely values, as a .bt, which makes more leaves equal. Equal leaves are pruned up to
  /// `pruned_levels` above the voxels.
  OctreeWriter(std::string* buffer, const OccupancyLogOdds& model, int pruned_levels)
      : buffer_(buffer), is_binary_(true), model_(model), pruned_levels_(pruned_levels) {}

  Node unknown() { return {}; }

  Node leaf(int, std::uint64_t, float log_odds) {
    const float written = likely(log_odds);
    append_leaf(written);
    return {true, true, true, log_odds, written};
  }

  template <typename Child>
  Node inner(int levels, std::uint64_t, const Child& child) {
    const std::uint64_t at = buffer_ ? buffer_->size() : 0, nodes_before = nodes;
    if (buffer_) buffer_->append("\0\0\0\0", is_binary_ ? 2 : 5);
    ++nodes;
    unsigned flags = 0, codes = 0;
    Node first, node{true, false, false, std::numeric_limits<float>::lowest(), 0};
    bool equal = levels < kTreeDepth, equal_written = equal;  // a .bt cannot express a root that is a leaf
    for (unsigned i = 0; i < 8; ++i) {
      const Node below = child(i);
      if (i == 0) first = below;
      equal = equal && below.is_leaf && below.is_inserted_leaf && below.log_odds == first.log_odds;
      equal_written = equal_written && below.is_leaf && below.written == first.written;
      if (!below.exists) continue;
      flags |= 1u << i;
      codes |= (below.is_leaf ? (is_occupied(below.written) ? 2u : 1u) : 3u) << (2 * i);
      node.log_odds = std::max(node.log_odds, below.log_odds);
    }
    if (flags == 0) {
      remove_from(at, nodes_before);
      return {};
    }
    node.written = likely(node.log_odds);
    if (!equal && equal_written) ++newly_equal[static_cast<std::size_t>(levels)];
    if (equal || (equal_written && levels <= pruned_levels_)) {
      remove_from(at, nodes_before);
      append_leaf(first.written);
      return {true, true, equal, first.log_odds, first.written};
    }
    overwrite(at, node.written, flags, codes);
    return node;
  }

  std::uint64_t nodes = 0;
  Counts newly_equal{};  ///< by level: inner nodes whose children are equal only in their most likely values

 private:
  float likely(float log_odds) const {
    if (!is_binary_) return log_odds;
    return is_occupied(log_odds) ? model_.clamping_max : model_.clamping_min;
  }

  void append_leaf(float log_odds) {
    ++nodes;
    if (!buffer_ || is_binary_) return;
    char bytes[5] = {};
    std::memcpy(bytes, &log_odds, 4);
    buffer_->append(bytes, 5);
  }

  void overwrite(std::uint64_t at, float log_odds, unsigned flags, unsigned codes) {
    if (!buffer_) return;
    char bytes[5];
    if (is_binary_) {
      bytes[0] = static_cast<char>(codes);
      bytes[1] = static_cast<char>(codes >> 8);
    } else {
      std::memcpy(bytes, &log_odds, 4);
      bytes[4] = static_cast<char>(flags);
    }
    std::memcpy(buffer_->data() + at, bytes, is_binary_ ? 2 : 5);
  }

  void remove_from(std::uint64_t at, std::uint64_t nodes_before) {
    if (buffer_) buffer_->resize(at);
    nodes = nodes_before;
  }

  std::string* const buffer_;
  const bool is_binary_ = false;
  const OccupancyLogOdds model_{};
  const int pruned_levels_ = 0;
};

OctreeWriter write(const BrickStore& store, OctreeWriter writer) {
  OctreeWalk(store, writer).run();
  return writer;
}

/// The shape of the tree after OctoMap's toMaxLikelihood and prune. OctoMap's prune proceeds upwards, level by level,
/// and stops at the first level where it prunes nothing, even if nodes above could be pruned; this shape reproduces
/// that behaviour.
struct LikelyShape {
  int pruned_levels;
  std::uint64_t nodes;
};

/// Derives the shape from the counts of `all`, a writer that has pruned all levels.
LikelyShape shape_by(const OctreeWriter& all) {
  const auto newly_equal = [&](int levels) { return all.newly_equal[static_cast<std::size_t>(levels)]; };
  LikelyShape shape{0, all.nodes};
  while (shape.pruned_levels + 1 < kTreeDepth && newly_equal(shape.pruned_levels + 1) > 0) ++shape.pruned_levels;
  for (int levels = shape.pruned_levels + 1; levels < kTreeDepth; ++levels) {
    shape.nodes += 8 * newly_equal(levels);  // `all` pruned these children, but OctoMap does not
  }
  return shape;
}

}  // namespace

TreeBytes full_tree(const BrickStore& store) {
  std::string buffer;
  const std::uint64_t nodes = write(store, OctreeWriter(&buffer)).nodes;
  return {std::move(buffer), nodes};
}

std::uint64_t count_nodes(const BrickStore& store) { return write(store, OctreeWriter(nullptr)).nodes; }

TreeBytes binary_tree(const BrickStore& store) {
  std::string guess;  // OctoMap usually prunes everything that can be pruned
  const OctreeWriter all = write(store, OctreeWriter(&guess, store.model(), kTreeDepth));
  const LikelyShape shape = shape_by(all);
  if (shape.nodes == all.nodes) return {std::move(guess), shape.nodes};
  std::string buffer;
  write(store, OctreeWriter(&buffer, store.model(), shape.pruned_levels));
  return {std::move(buffer), shape.nodes};
}

}  // namespace uwsim::bricks
