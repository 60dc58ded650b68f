#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "uwsim/mapping/bricks/brick_store.h"
#include "uwsim/mapping/map_engine.h"

/// Functions that treat a store of bricks as OctoMap's octree: they list its leaves, and write and read OctoMap's
/// files. Inner nodes and pruned leaves are computed on the fly and never stored.
namespace uwsim::bricks {

// Defined in brick_octree_leaves.cpp:

/// Visits the leaves in Morton order.
void for_each_leaf(const BrickStore& store, const MapEngine::LeafVisitor& leaf);

/// Visits the leaves that contain voxels of the box.
void for_each_leaf_in(const BrickStore& store, const KeyBox& box, const MapEngine::LeafVisitor& leaf);

/// Returns the numbers of voxels, or nullopt if counting them would require iterating over large leaves.
std::optional<VoxelCounts> count_voxels(const BrickStore& store);

/// Sets the bits of a chunk's occupied voxels; bits are in Morton order.
void occupied_in(const BrickStore& store, std::uint32_t chunk, OccupiedWords& words);

// Defined in brick_octree_write.cpp:

/// Returns, as the body of an .ot, the tree that OctoMap would have after the same scans: eight equal leaves are pruned
/// to one, and an inner node holds the maximum of its children.
TreeBytes full_tree(const BrickStore& store);
std::uint64_t count_nodes(const BrickStore& store);

/// Returns the same tree after OctoMap's toMaxLikelihood and prune as the body of a .bt, identical to what
/// octomap::OcTree writes.
TreeBytes binary_tree(const BrickStore& store);

// Defined in brick_octree_read.cpp:

/// Fills an empty store from the tree of a file that check_octree_file() accepted.
void load_tree(BrickStore& store, MapFormat format, std::string_view body);

}  // namespace uwsim::bricks
