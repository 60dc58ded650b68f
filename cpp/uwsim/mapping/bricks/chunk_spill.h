#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <unordered_map>

#include "uwsim/mapping/bricks/spill_file.h"

namespace uwsim::bricks {

/// The state of a BrickStore with a memory limit: which chunks the spill file has.
struct ChunkSpill {
  ChunkSpill(std::size_t limit, const std::string& folder) : limit_bytes(limit), file(folder) {}

  std::size_t limit_bytes;
  SpillFile file;
  std::unordered_map<std::uint32_t, SpillFile::Extent> saved;  ///< chunks that the file has, whether or not in memory
  std::uint64_t clock = 0;                                     ///< counts uses of chunks
  std::uint64_t evictions = 0;
  std::string error;  ///< why the last attempt to write the file failed; empty if it succeeded
};

}  // namespace uwsim::bricks
