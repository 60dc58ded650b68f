#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include "uwsim/mapping/map_engine.h"

namespace uwsim {

/// Which voxels became unknown, free or occupied since they were last asked for. It keeps the states it has told: 2 kB
/// a chunk and 128 bytes for each brick that is not one state all over.
class MapChanges {
 public:
  struct Changed {
    VoxelKey key;
    std::int8_t state;  ///< 1 occupied, 0 free, -1 unknown
  };

  /// In Morton order; all that is known at the first call. Throws InvalidValue past `most`, and then the next call
  /// tells them.
  std::vector<Changed> take(MapEngine& engine, std::size_t most);

 private:
  enum class Kind : std::uint8_t { unknown, free, occupied, mixed };
  struct States {
    std::uint64_t known[8], occupied[8];
  };
  struct ChunkStates {
    std::array<Kind, 512> kinds{};
    std::vector<States> mixed;  ///< of those bricks, in their order

    std::vector<States> unpacked() const;
  };

  static ChunkStates packed(const std::vector<States>& bricks);
  static std::vector<States> states_now(const MapEngine& engine, std::uint32_t chunk);

  ChangedChunks pending_;
  std::map<std::uint32_t, ChunkStates> told_;
};

}  // namespace uwsim
