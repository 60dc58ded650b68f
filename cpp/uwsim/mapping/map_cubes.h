#pragma once

#include <functional>

#include "uwsim/mapping/map_engine.h"

/// Lists of a map's cubes, identical for both engines.
namespace uwsim {

/// A cube with an edge of 2^levels voxels.
struct MapCube {
  VoxelKey corner;
  int levels;
  float log_odds;
};

using CubeVisitor = std::function<void(const MapCube&)>;

/// Visits the leaves of OctoMap's pruned tree, in Morton order: eight equal leaves are merged into one, which is at
/// most an eighth of the root's cube.
void for_each_pruned_leaf(const MapEngine& engine, const CubeVisitor& visit);

/// Visits the cubes with an edge of 2^levels voxels that contain known voxels, in Morton order. A cube's log-odds are
/// the maximum of those inside it, as in OctoMap's inner nodes.
void for_each_cell(const MapEngine& engine, int levels, const CubeVisitor& visit);

/// Visits the known voxels of a box, in Morton order.
void for_each_voxel_in(const MapEngine& engine, const KeyBox& box, const CubeVisitor& visit);

}  // namespace uwsim
