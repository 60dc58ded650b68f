#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "uwsim/core/instruction_set.h"
#include "uwsim/mapping/map_engine.h"

namespace uwsim {

/// Creates an engine that stores OctoMap's map as bricks of voxels. It produces the same bytes as OctomapEngine in a
/// fraction of the time and memory; README.md in this folder explains how. tree_origin_world_m: the position of the
/// tree's origin. memory_limit_bytes: the memory that voxels may take before the least recently used ones are moved to
/// an unnamed file in spill_folder (if empty, the system's folder for temporary files); 0 for no limit. Throws
/// InvalidValue if the processor does not support the instruction set, FileError if the file cannot be created.
std::unique_ptr<MapEngine> make_brick_engine(double resolution_m, const Eigen::Vector3d& tree_origin_world_m,
                                             const OccupancyModel& model, InstructionSet instruction_set,
                                             std::size_t memory_limit_bytes, const std::string& spill_folder);

}  // namespace uwsim
