#pragma once

#include <cstdint>
#include <set>

#include "uwsim/mapping/voxel_key.h"

namespace uwsim {

/// The 64 x 64 x 64 voxels of a chunk. `code`: the Morton code of any of its voxels without the lowest 18 bits.
KeyBox chunk_box(std::uint32_t code);

/// Chunks that contain voxels that may have changed.
struct ChangedChunks {
  bool all = false;
  std::set<std::uint32_t> codes;

  /// Adds the chunks of a cube with an edge of 2^levels voxels.
  void add(const VoxelKey& corner, int levels);
};

}  // namespace uwsim
