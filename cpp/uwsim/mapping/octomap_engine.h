#pragma once

#include <memory>

#include "uwsim/mapping/map_engine.h"

namespace octomap {
class OcTree;
}

namespace uwsim {

/// The reference: Debian's octomap::OcTree, whose insertPointCloud inserts the scans (eagerly: inner nodes are updated
/// and pruned after every voxel). Scans are passed directly to the tree.
std::unique_ptr<MapEngine> make_octomap_engine(double resolution_m, const Eigen::Vector3d& tree_origin_world_m,
                                               const OccupancyModel& model);

/// Creates an octomap::OcTree from the tree of an .ot, with this model.
std::shared_ptr<octomap::OcTree> octree_of(const TreeBytes& full_tree, double resolution_m,
                                           const OccupancyModel& model);

/// The tree of a .bt, as read and written again by an octomap::OcTree.
TreeBytes written_by_octomap(const TreeBytes& binary_tree, double resolution_m, const OccupancyModel& model);

}  // namespace uwsim
