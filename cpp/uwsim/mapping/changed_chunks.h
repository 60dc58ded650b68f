#pragma once

#include <cstdint>
#include <set>

#include "uwsim/mapping/voxel_key.h"

namespace uwsim {

/// The 64 x 64 x 64 voxels of a chunk. `code`: the Morton code of a voxel in it without the lowest 18 bits.
KeyBox chunk_box(std::uint32_t code);

/// Chunks in which voxels may have changed.
struct ChangedChunks {
  bool all = false;
  std::set<std::uint32_t> codes;

  /// The chunks of a cube of 2^levels voxels an edge.
  void add(const VoxelKey& corner, int levels);
};

}  // namespace uwsim
