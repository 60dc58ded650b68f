#pragma once

#include <array>
#include <vector>

#include "uwsim/rays/ray_tile.h"

namespace uwsim {

/// A tile that some rays of a packet reach.
struct ReachedTile {
  const RayTile* tile;
  double soonest_m;
  /// Where each ray enters the tile: 0 from inside, infinity for a miss
  alignas(64) std::array<double, kPacketRays> start_m;
};

/// The tiles that a packet's active rays reach, earliest first.
std::vector<ReachedTile> reached_tiles(const std::vector<RayTile>& tiles, const ExactRays& rays);

}  // namespace uwsim
