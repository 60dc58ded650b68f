#pragma once

#include <memory>
#include <string>

#include "uwsim/mapping/map_engine.h"
#include "uwsim/mapping/scan_kernels.h"

namespace uwsim {

/// OctoMap's tree kept as bricks of voxels: the same bytes as OctomapEngine's, at a fraction of its time and memory.
/// Throws InvalidValue if the processor does not know the instruction set. tree_origin_world_m: where the tree's zero
/// is. memory_limit_bytes: what its voxels may take of memory before the least recently used go to a nameless file in
/// spill_folder (empty: the system's); 0 for no limit. Throws FileError if no such file can be made.
std::unique_ptr<MapEngine> make_brick_engine(double resolution_m, const Eigen::Vector3d& tree_origin_world_m,
                                             const OccupancyModel& model, InstructionSet instruction_set,
                                             std::size_t memory_limit_bytes, const std::string& spill_folder);

}  // namespace uwsim
