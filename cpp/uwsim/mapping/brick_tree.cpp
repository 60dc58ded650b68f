#include "uwsim/mapping/brick_tree.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>

#include "uwsim/mapping/brick_descent.h"
#include "uwsim/mapping/morton.h"
#include "uwsim/mapping/tree_buffer.h"

namespace uwsim::bricks {
namespace {

class LeafLister {
 public:
  LeafLister(const MapEngine::LeafVisitor& visit) : visit_(visit) {}
  bool unknown() { return false; }
  bool leaf(int levels, std::uint64_t code, float log_odds) {
    visit_(morton::key(code), levels, log_odds);
    return true;
  }
  template <typename Child>
  bool inner(int, std::uint64_t, const Child& child) {
    for (unsigned i = 0; i < 8; ++i) child(i);
    return true;
  }

 private:
  const MapEngine::LeafVisitor& visit_;
};

/// The same of a box.
class BoxLister {
 public:
  BoxLister(const KeyBox& box, const MapEngine::LeafVisitor& visit) : box_(box), visit_(visit) {}
  bool unknown() { return false; }
  bool leaf(int levels, std::uint64_t code, float log_odds) {
    const VoxelKey corner = morton::key(code);
    if (box_.meets(corner, levels)) visit_(corner, levels, log_odds);
    return true;
  }
  template <typename Child>
  bool inner(int levels, std::uint64_t code, const Child& child) {
    for (unsigned i = 0; i < 8; ++i) {
      if (box_.meets(morton::key(code + (std::uint64_t{i} << (3 * (levels - 1)))), levels - 1)) child(i);
    }
    return true;
  }

 private:
  const KeyBox& box_;
  const MapEngine::LeafVisitor& visit_;
};

/// Writes nodes in preorder, in one of OctoMap's forms: full, a float of log-odds and a byte of child flags each;
/// binary, two bits a child in the two bytes of an inner node. A node comes before its children and is only known after
/// them: it is mended, or, if they are one, they are taken back.
class TreeWriter {
 public:
  struct Node {
    bool exists = false;
    bool is_leaf = false;
    bool as_inserted = false;  ///< a leaf before all became maximum likelihood
    float log_odds = 0;
    float written = 0;
  };
  using Counts = std::array<std::uint64_t, kTreeDepth + 1>;

  /// Everything: full log-odds. buffer: null to count alone.
  explicit TreeWriter(TreeBuffer* buffer) : buffer_(buffer) {}
  /// Maximum likelihood, which makes more leaves equal; those are united up to `united_levels` above the finest.
  TreeWriter(TreeBuffer* buffer, MapFormat form, const SensorModel& model, int united_levels)
      : buffer_(buffer),
        is_binary_(form == MapFormat::bt),
        is_likely_(true),
        model_(model),
        united_levels_(united_levels) {}

  Node unknown() { return {}; }

  Node leaf(int, std::uint64_t, float log_odds) {
    const float written = likely(log_odds);
    put_leaf(written);
    return {true, true, true, log_odds, written};
  }

  template <typename Child>
  Node inner(int levels, std::uint64_t, const Child& child) {
    const std::uint64_t at = buffer_ ? buffer_->size() : 0, nodes_before = nodes;
    if (buffer_) buffer_->append("\0\0\0\0", is_binary_ ? 2 : 5);
    ++nodes;
    unsigned flags = 0, codes = 0;
    Node first, node{true, false, false, std::numeric_limits<float>::lowest(), 0};
    bool equal = levels < kTreeDepth, equal_written = equal;  // a .bt says nothing of a root that is a leaf
    for (unsigned i = 0; i < 8; ++i) {
      const Node below = child(i);
      if (i == 0) first = below;
      equal = equal && below.is_leaf && below.as_inserted && below.log_odds == first.log_odds;
      equal_written = equal_written && below.is_leaf && below.written == first.written;
      if (!below.exists) continue;
      flags |= 1u << i;
      codes |= (below.is_leaf ? (OccupancyModel::is_occupied(below.written) ? 2u : 1u) : 3u) << (2 * i);
      node.log_odds = std::max(node.log_odds, below.log_odds);
    }
    if (flags == 0) {
      take_back(at, nodes_before);
      return {};
    }
    node.written = likely(node.log_odds);
    if (!equal && equal_written) ++united[static_cast<std::size_t>(levels)];
    if (equal || (equal_written && levels <= united_levels_)) {
      take_back(at, nodes_before);
      put_leaf(first.written);
      return {true, true, equal, first.log_odds, first.written};
    }
    mend(at, node.written, flags, codes);
    return node;
  }

  std::uint64_t nodes = 0;
  Counts united{};  ///< nodes by level that were united, or would have been, only for being maximum likelihood

 private:
  float likely(float log_odds) const {
    if (!is_likely_) return log_odds;
    return OccupancyModel::is_occupied(log_odds) ? model_.highest : model_.lowest;
  }

  void put_leaf(float log_odds) {
    ++nodes;
    if (!buffer_ || is_binary_) return;
    char bytes[5] = {};
    std::memcpy(bytes, &log_odds, 4);
    buffer_->append(bytes, 5);
  }

  void mend(std::uint64_t at, float log_odds, unsigned flags, unsigned codes) {
    if (!buffer_) return;
    char bytes[5];
    if (is_binary_) {
      bytes[0] = static_cast<char>(codes);
      bytes[1] = static_cast<char>(codes >> 8);
    } else {
      std::memcpy(bytes, &log_odds, 4);
      bytes[4] = static_cast<char>(flags);
    }
    buffer_->mend(at, bytes, is_binary_ ? 2 : 5);
  }

  void take_back(std::uint64_t at, std::uint64_t nodes_before) {
    if (buffer_) buffer_->take_back(at);
    nodes = nodes_before;
  }

  TreeBuffer* const buffer_;
  const bool is_binary_ = false, is_likely_ = false;
  const SensorModel model_{};
  const int united_levels_ = 0;
};

TreeWriter write(const BrickStore& store, TreeWriter writer) {
  Descent(store, writer).run();
  return writer;
}

struct LikelyShape {
  int united_levels;
  std::uint64_t nodes;
};

/// Up to which level OctoMap's prune comes, and what is left then.
LikelyShape likely_shape(const BrickStore& store) {
  const TreeWriter all = write(store, TreeWriter(nullptr, MapFormat::ot, store.model(), kTreeDepth));
  LikelyShape shape{0, all.nodes};
  while (shape.united_levels + 1 < kTreeDepth && all.united[static_cast<std::size_t>(shape.united_levels) + 1] > 0) {
    ++shape.united_levels;
  }
  for (int levels = shape.united_levels + 1; levels < kTreeDepth; ++levels) {
    shape.nodes += 8 * all.united[static_cast<std::size_t>(levels)];  // children that stay
  }
  return shape;
}

TreeBytes likely(const BrickStore& store, MapFormat form) {
  TreeBuffer buffer;
  const TreeWriter written = write(store, TreeWriter(&buffer, form, store.model(), likely_shape(store).united_levels));
  return {buffer.take(), written.nodes};
}

}  // namespace

void for_each_leaf(const BrickStore& store, const MapEngine::LeafVisitor& leaf) {
  LeafLister lister(leaf);
  Descent(store, lister).run();
}

void for_each_leaf_in(const BrickStore& store, const KeyBox& box, const MapEngine::LeafVisitor& leaf) {
  BoxLister lister(box, leaf);
  Descent(store, lister, store.sorted_chunks(box)).run();
}

TreeBytes full_tree(const BrickStore& store) {
  TreeBuffer buffer;
  const std::uint64_t nodes = write(store, TreeWriter(&buffer)).nodes;
  return {buffer.take(), nodes};
}

std::uint64_t count_nodes(const BrickStore& store) { return write(store, TreeWriter(nullptr)).nodes; }

TreeBytes likely_tree(const BrickStore& store) { return likely(store, MapFormat::ot); }
TreeBytes binary_tree(const BrickStore& store) { return likely(store, MapFormat::bt); }

void write_tree(const BrickStore& store, MapFormat format, double resolution_m, AtomicFile& file) {
  const LikelyShape shape = format == MapFormat::bt ? likely_shape(store) : LikelyShape{kTreeDepth, count_nodes(store)};
  file.append(octree_header(format, shape.nodes, resolution_m));
  TreeBuffer buffer(&file);
  write(store, format == MapFormat::bt ? TreeWriter(&buffer, MapFormat::bt, store.model(), shape.united_levels)
                                       : TreeWriter(&buffer));
  buffer.flush();
}

}  // namespace uwsim::bricks
