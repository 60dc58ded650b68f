#include "uwsim/mapping/bricks/brick_octree.h"
#include "uwsim/mapping/bricks/brick_octree_walk.h"
#include "uwsim/mapping/morton.h"

namespace uwsim::bricks {
namespace {

class LeafLister {
 public:
  explicit LeafLister(const MapEngine::LeafVisitor& visit) : visit_(visit) {}
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

/// Leaves out the cubes that do not meet a box.
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

}  // namespace

void for_each_leaf(const BrickStore& store, const MapEngine::LeafVisitor& leaf) {
  LeafLister lister(leaf);
  OctreeWalk(store, lister).run();
}

void for_each_leaf_in(const BrickStore& store, const KeyBox& box, const MapEngine::LeafVisitor& leaf) {
  BoxLister lister(box, leaf);
  OctreeWalk(store, lister, store.sorted_chunks(box)).run();
}

}  // namespace uwsim::bricks
