#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "uwsim/mapping/map_engine.h"

namespace uwsim {

/// Tracks which voxels became unknown, free or occupied since the last call. It stores the states that it has reported:
/// 2 kB per chunk, plus 128 bytes for each brick whose voxels differ.
class MapChanges {
 public:
  struct Changed {
    VoxelKey key;
    std::int8_t state;  ///< 1 occupied, 0 free, -1 unknown
  };

  /// Records which chunks may have changed.
  void note(const ChangedChunks& chunks);
  /// Returns changed voxels in Morton order; on the first call, all known voxels. Throws InvalidValue if there are more
  /// than `most`; the next call then reports them.
  std::vector<Changed> take(const MapEngine& engine, std::size_t most);

 private:
  enum class Kind : std::uint8_t { unknown, free, occupied, mixed };
  /// The states of the voxels of a brick, one bit each.
  struct States {
    std::uint64_t known[8], occupied[8];
  };
  struct ChunkStates {
    std::array<Kind, 512> kinds{};  ///< of the bricks
    std::vector<States> mixed;      ///< of the mixed bricks, in order

    std::vector<States> unpacked() const;
  };

  static ChunkStates packed(const std::vector<States>& bricks);
  static std::vector<States> states_now(const MapEngine& engine, std::uint32_t chunk);
  static void append_changes(std::uint32_t chunk, const std::vector<States>& before, const std::vector<States>& now,
                             std::vector<Changed>& changed);
  void list_pending(const MapEngine& engine, std::size_t most);

  ChangedChunks pending_{true, {}};                ///< chunks with changes that have not been reported
  std::map<std::uint32_t, ChunkStates> reported_;  ///< by the chunk's code
};

}  // namespace uwsim
