#include "uwsim/mapping/map_merge.h"

#include <algorithm>
#include <bit>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

constexpr std::uint64_t kPiecesMax = 4'000'000'000;

/// The largest number of levels whose cubes are still aligned after the shift.
int whole_levels(const VoxelKey& shift) {
  const int all = shift[0] | shift[1] | shift[2];
  return all == 0 ? kTreeDepth : std::countr_zero(static_cast<unsigned>(all));
}

}  // namespace

void merge(MapEngine& into, const MapEngine& other, const VoxelKey& shift) {
  const int whole = whole_levels(shift);
  std::uint64_t pieces = 0;
  other.for_each_leaf([&](const VoxelKey& corner, int levels, float) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const int first = corner[axis] + shift[axis], last = first + (1 << levels) - 1;
      require(first >= 0 && last < 1 << kTreeDepth, "merge.shift_voxels", shift[axis],
              "puts a part of the other map outside this map's cube (+-2^15 voxels about its origin)");
    }
    pieces += std::uint64_t{1} << (3 * (levels - std::min(levels, whole)));
  });
  require(pieces <= kPiecesMax, "merge.voxels", pieces,
          "must be at most 4,000,000,000 when the maps' origins are an odd number of voxels apart");
  other.for_each_leaf([&](const VoxelKey& corner, int levels, float log_odds) {
    const int size = std::min(levels, whole), step = 1 << size, end = 1 << levels;
    for (int z = 0; z < end; z += step) {
      for (int y = 0; y < end; y += step) {
        for (int x = 0; x < end; x += step) {
          into.add({corner[0] + shift[0] + x, corner[1] + shift[1] + y, corner[2] + shift[2] + z}, size, log_odds);
        }
      }
    }
  });
  into.finish_adding();
}

}  // namespace uwsim
