#include "uwsim/mapping/brick_tree.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>

#include "uwsim/mapping/brick_descent.h"
#include "uwsim/mapping/morton.h"

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

/// Writes nodes in preorder, a float of log-odds and a byte of child flags each. A node comes before its children and
/// is only known after them: it is mended, or, if they are one, they are taken back.
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

  /// Everything: full log-odds.
  TreeWriter(bool keeps_bytes) : keeps_bytes_(keeps_bytes) {}
  /// Maximum likelihood, which makes more leaves equal; those are united up to `united_levels` above the finest.
  TreeWriter(bool keeps_bytes, const SensorModel& model, int united_levels)
      : keeps_bytes_(keeps_bytes), is_likely_(true), model_(model), united_levels_(united_levels) {}

  Node unknown() { return {}; }

  Node leaf(int, std::uint64_t, float log_odds) {
    const float written = likely(log_odds);
    put(tree.body.size(), written, 0, true);
    return {true, true, true, log_odds, written};
  }

  template <typename Child>
  Node inner(int levels, std::uint64_t, const Child& child) {
    const std::size_t at = tree.body.size();
    const std::uint64_t nodes_before = tree.nodes;
    put(at, 0, 0, true);
    unsigned flags = 0;
    Node first, node{true, false, false, std::numeric_limits<float>::lowest(), 0};
    bool equal = levels < kTreeDepth, equal_written = equal;  // a .bt says nothing of a root that is a leaf
    for (unsigned i = 0; i < 8; ++i) {
      const Node below = child(i);
      if (i == 0) first = below;
      equal = equal && below.is_leaf && below.as_inserted && below.log_odds == first.log_odds;
      equal_written = equal_written && below.is_leaf && below.written == first.written;
      if (!below.exists) continue;
      flags |= 1u << i;
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
      put(at, first.written, 0, true);
      return {true, true, equal, first.log_odds, first.written};
    }
    put(at, node.written, flags, false);
    return node;
  }

  TreeBytes tree;
  Counts united{};  ///< nodes by level that were united, or would have been, only for being maximum likelihood

 private:
  float likely(float log_odds) const {
    if (!is_likely_) return log_odds;
    return OccupancyModel::is_occupied(log_odds) ? model_.highest : model_.lowest;
  }

  void put(std::size_t at, float log_odds, unsigned flags, bool is_new) {
    tree.nodes += is_new;
    if (!keeps_bytes_) return;
    char bytes[5];
    std::memcpy(bytes, &log_odds, 4);
    bytes[4] = static_cast<char>(flags);
    is_new ? tree.body.append(bytes, 5) : tree.body.replace(at, 5, bytes, 5);
  }

  void take_back(std::size_t at, std::uint64_t nodes_before) {
    tree.body.resize(at);
    tree.nodes = nodes_before;
  }

  const bool keeps_bytes_, is_likely_ = false;
  const SensorModel model_{};
  const int united_levels_ = 0;
};

TreeWriter write(const BrickStore& store, TreeWriter writer) {
  Descent(store, writer).run();
  return writer;
}

}  // namespace

void for_each_leaf(const BrickStore& store, const MapEngine::LeafVisitor& leaf) {
  LeafLister lister(leaf);
  Descent(store, lister).run();
}

TreeBytes full_tree(const BrickStore& store) { return write(store, TreeWriter(true)).tree; }

std::uint64_t count_nodes(const BrickStore& store) { return write(store, TreeWriter(false)).tree.nodes; }

TreeBytes likely_tree(const BrickStore& store) {
  const TreeWriter::Counts united = write(store, TreeWriter(false, store.model(), kTreeDepth)).united;
  int levels = 0;
  while (levels + 1 < kTreeDepth && united[static_cast<std::size_t>(levels) + 1] > 0) ++levels;
  return write(store, TreeWriter(true, store.model(), levels)).tree;
}

}  // namespace uwsim::bricks
