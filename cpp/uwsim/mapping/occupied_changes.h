#pragma once

#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

#include "uwsim/mapping/map_engine.h"

namespace uwsim {

/// Tracks which voxels have become occupied, or ceased to be occupied, since the last call. Free water, which accounts
/// for most of the changes that scans cause, takes no memory: 12 bytes are stored for each cube of 4 x 4 x 4 voxels
/// that contains an occupied voxel, and nothing for other cubes.
class OccupiedChanges {
 public:
  struct Changed {
    VoxelKey key;
    bool is_occupied;
  };

  /// Records which chunks may have changed.
  void note(const ChangedChunks& chunks);
  /// Returns changed voxels in Morton order; on the first call, all occupied voxels. Throws InvalidValue if there are
  /// more than `most`; the next call then reports them.
  std::vector<Changed> take(const MapEngine& engine, std::size_t most);

 private:
  /// The nonzero words of a chunk, each with 64 voxels, in Morton order.
  using Words = std::vector<std::pair<std::uint16_t, std::uint64_t>>;

  ChangedChunks pending_{true, {}};
  std::unordered_map<std::uint32_t, Words> reported_;  ///< by the chunk's code
};

}  // namespace uwsim
