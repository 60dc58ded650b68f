#pragma once

#include <memory>

#include "uwsim/mapping/map_engine.h"
#include "uwsim/mapping/scan_kernels.h"

namespace uwsim {

/// OctoMap's tree kept as bricks of voxels: the same bytes as OctomapEngine's, at a fraction of its time and memory.
/// Throws InvalidValue if the processor does not know the instruction set. tree_origin_world_m: where the tree's zero
/// is.
std::unique_ptr<MapEngine> make_brick_engine(double resolution_m, const Eigen::Vector3d& tree_origin_world_m,
                                             const OccupancyModel& model, InstructionSet instruction_set);

}  // namespace uwsim
