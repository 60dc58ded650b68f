#pragma once

#include <cstdint>
#include <string_view>

#include "uwsim/mapping/brick_store.h"
#include "uwsim/mapping/map_engine.h"

/// Bricks as an octree: its inner nodes and its pruning exist only while it is asked for.
namespace uwsim::bricks {

/// In Morton order.
void for_each_leaf(const BrickStore& store, const MapEngine::LeafVisitor& leaf);

/// What OctoMap would have after the same scans: eight equal leaves are one, an inner node is the greatest of its
/// children.
TreeBytes full_tree(const BrickStore& store);
std::uint64_t count_nodes(const BrickStore& store);

/// The same after OctoMap's toMaxLikelihood and prune, in the form of an .ot. That prune goes up level by level and
/// ends at the first where nothing is left to prune, even if there is higher up: so does this.
TreeBytes likely_tree(const BrickStore& store);

/// Fills an empty store from the tree of a file that is sound.
void load_tree(BrickStore& store, MapFormat format, std::string_view body);

}  // namespace uwsim::bricks
