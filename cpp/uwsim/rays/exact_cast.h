#pragma once

#include <span>

#include "uwsim/rays/ray_packet.h"
#include "uwsim/rays/tile_trees.h"

namespace uwsim {

/// Finds the true first hits in a tile, for rays that start `starts_m` along their direction (at 0 if null).
void cast_exact(const TileTrees& tile, const ExactRays& rays, const double* starts_m, ExactHits& hits);
/// The same for several packets whose rays start at 0. Casting them together is faster, because memory is prefetched.
void cast_exact(const TileTrees& tile, std::span<const ExactRays> rays, std::span<ExactHits> hits);

}  // namespace uwsim
