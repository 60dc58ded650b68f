#pragma once

#include <memory>

#include "uwsim/mapping/map_engine.h"

namespace octomap {
class OcTree;
}

namespace uwsim {

/// Creates the reference engine, which is Debian's octomap::OcTree. Scans are passed directly to its insertPointCloud,
/// with eager evaluation: inner nodes are updated and pruned after every voxel.
std::unique_ptr<MapEngine> make_octomap_engine(double resolution_m, const Eigen::Vector3d& tree_origin_world_m,
                                               const OccupancyModel& model);

/// Creates an octomap::OcTree from the tree of an .ot, with this model.
std::shared_ptr<octomap::OcTree> octree_of(const TreeBytes& full_tree, double resolution_m,
                                           const OccupancyModel& model);

/// Returns the tree of a .bt after an octomap::OcTree has read it and written it again.
TreeBytes written_by_octomap(const TreeBytes& binary_tree, double resolution_m, const OccupancyModel& model);

}  // namespace uwsim
