#pragma once

#include <string_view>

#include "uwsim/mapping/map_engine.h"

namespace uwsim {

/// Adds the log-odds of another map to those of `into`, voxel by voxel: an unknown voxel counts as 0, and the sum is
/// clamped to the limits of `into`. shift: voxels from the corner of `into` to that of the other map. Throws
/// InvalidValue, having changed nothing, if a part of the other map would lie outside the cube, or if its large leaves
/// would have to be cut into so many pieces that it would take minutes.
void merge(MapEngine& into, const MapEngine& other, const VoxelKey& shift);

}  // namespace uwsim
