#include "uwsim/mapping/changed_chunks.h"

#include "uwsim/mapping/morton.h"

namespace uwsim {
namespace {

/// A larger cube has too many chunks to list, so all chunks count as changed.
constexpr int kListedLevelsMax = 10;

}  // namespace

KeyBox chunk_box(std::uint32_t code) {
  const VoxelKey low = morton::key(std::uint64_t{code} << 18);
  return {low, {low[0] + 63, low[1] + 63, low[2] + 63}};
}

void ChangedChunks::add(const VoxelKey& corner, int levels) {
  if (all) return;
  if (levels > kListedLevelsMax) {
    all = true;
    return;
  }
  const auto first = static_cast<std::uint32_t>(morton::code(corner) >> 18);
  const std::uint32_t count = levels <= 6 ? 1 : 1u << (3 * (levels - 6));
  for (std::uint32_t i = 0; i < count; ++i) codes.insert(codes.end(), first + i);
}

}  // namespace uwsim
