#pragma once

#include <string_view>

#include "uwsim/mapping/map_engine.h"

namespace uwsim {

/// Adds the other's log-odds to `into`, voxel by voxel; unknown is 0, the sum is clamped to the limits of `into`.
/// shift: voxels from the other's corner to that of `into`. Throws InvalidValue, having changed nothing, if the other
/// reaches outside the cube, or so much of it lies across the lattice that it would take minutes.
void merge(MapEngine& into, const MapEngine& other, const VoxelKey& shift);

}  // namespace uwsim
