#pragma once

#include <memory>

#include "uwsim/mapping/map_engine.h"

namespace octomap {
class OcTree;
}

namespace uwsim {

/// The reference: Debian's octomap::OcTree, scans inserted by its insertPointCloud as it comes (eager: inner nodes and
/// pruning after every voxel), no code of ours between a scan and the tree.
std::unique_ptr<MapEngine> make_octomap_engine(double resolution_m, const Eigen::Vector3d& tree_origin_world_m,
                                               const OccupancyModel& model);

/// A tree in the form of an .ot as a real octomap::OcTree, with the model as its own.
std::shared_ptr<octomap::OcTree> octree_of(const TreeBytes& full_tree, double resolution_m,
                                           const OccupancyModel& model);

/// A tree of occupied and free alone, in the form of an .ot, as an octomap::OcTree writes it into a .bt.
TreeBytes written_by_octomap(const TreeBytes& likely_tree, double resolution_m, const OccupancyModel& model);

}  // namespace uwsim
