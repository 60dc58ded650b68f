#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <unordered_map>

#include "uwsim/mapping/bricks/spill_file.h"

namespace uwsim::bricks {

/// The state of a BrickStore with a memory limit.
struct ChunkSpill {
  ChunkSpill(std::size_t limit, const std::string& folder) : limit_bytes(limit), file(folder) {}

  std::size_t limit_bytes;
  SpillFile file;
  /// chunks in the file, whether or not they are in memory
  std::unordered_map<std::uint32_t, SpillFile::Extent> saved;
  std::uint64_t clock = 0;  ///< increases with every use of a chunk
  std::uint64_t evictions = 0;
  std::string error;  ///< why the last attempt to write the file failed; empty if it succeeded
};

}  // namespace uwsim::bricks
