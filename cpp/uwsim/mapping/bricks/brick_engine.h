#pragma once

#include <memory>

#include "uwsim/core/instruction_set.h"
#include "uwsim/mapping/map_engine.h"

namespace uwsim {

/// Creates an engine that stores OctoMap's map as bricks of voxels. It produces the same bytes as OctomapEngine in a
/// fraction of the time and memory; README.md in this folder explains how. tree_origin_world_m: the position of the
/// tree's origin. Throws InvalidValue if the processor does not support the instruction set.
std::unique_ptr<MapEngine> make_brick_engine(double resolution_m, const Eigen::Vector3d& tree_origin_world_m,
                                             const OccupancyModel& model, InstructionSet instruction_set);

}  // namespace uwsim
