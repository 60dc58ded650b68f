#pragma once

#include <cstdint>
#include <string_view>

#include "uwsim/mapping/brick_store.h"
#include "uwsim/mapping/map_engine.h"

namespace uwsim {
class AtomicFile;
}

/// Bricks as an octree: its inner nodes and its pruning exist only while it is asked for.
namespace uwsim::bricks {

/// In Morton order.
void for_each_leaf(const BrickStore& store, const MapEngine::LeafVisitor& leaf);

/// Those with voxels of the box.
void for_each_leaf_in(const BrickStore& store, const KeyBox& box, const MapEngine::LeafVisitor& leaf);

/// What OctoMap would have after the same scans: eight equal leaves are one, an inner node is the greatest of its
/// children.
TreeBytes full_tree(const BrickStore& store);
std::uint64_t count_nodes(const BrickStore& store);

/// The same after OctoMap's toMaxLikelihood and prune, in the form of an .ot. That prune goes up level by level and
/// ends at the first where nothing is left to prune, even if there is higher up: so does this.
TreeBytes likely_tree(const BrickStore& store);
/// The same as a .bt: the bytes that an octomap::OcTree makes of it.
TreeBytes binary_tree(const BrickStore& store);

/// The whole file, chunk by chunk: the memory it takes does not depend on the map.
void write_tree(const BrickStore& store, MapFormat format, double resolution_m, AtomicFile& file);

/// Fills an empty store from the tree of a file that is sound.
void load_tree(BrickStore& store, MapFormat format, std::string_view body);

}  // namespace uwsim::bricks
