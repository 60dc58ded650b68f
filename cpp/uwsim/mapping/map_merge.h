#pragma once

#include <string_view>

#include "uwsim/mapping/map_engine.h"

namespace uwsim {

/// Adds the log-odds of another map to those of `into`, voxel by voxel: an unknown voxel counts as 0, and the sum is
/// clamped to the limits of `into`. shift: offset of the other map's corner from the corner of `into`, in voxels. If
/// part of the other map would lie outside OctoMap's cube, or if splitting its large leaves would take minutes, throws
/// InvalidValue without changing anything.
void merge(MapEngine& into, const MapEngine& other, const VoxelKey& shift);

}  // namespace uwsim
