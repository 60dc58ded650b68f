#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace uwsim {

/// OctoMap's tree has 16 levels below its root, so a voxel's key has 16 bits per axis.
inline constexpr int kTreeDepth = 16;
/// Distance in voxels from the centre of OctoMap's cube, which is the tree's origin, to the cube's faces.
inline constexpr int kHalfExtent = 1 << (kTreeDepth - 1);

/// A voxel's position in OctoMap's cube: the number of voxels from the cube's corner along each axis, 0 to 65,535. A
/// larger cube of the octree, with an edge of 2^levels voxels, has the key of its lowest voxel.
using VoxelKey = std::array<int, 3>;

/// The i-th eighth, in Morton order, of a cube whose half edge is `half` voxels.
constexpr VoxelKey child_corner(const VoxelKey& corner, int i, int half) {
  return {corner[0] + (i & 1) * half, corner[1] + (i >> 1 & 1) * half, corner[2] + (i >> 2 & 1) * half};
}

struct VoxelCounts {
  std::uint64_t occupied = 0, free = 0;
};

/// All voxels from `low` to `high`, inclusive.
struct KeyBox {
  VoxelKey low, high;

  /// Whether a cube with an edge of 2^levels voxels overlaps the box.
  bool meets(const VoxelKey& corner, int levels) const {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (corner[axis] > high[axis] || corner[axis] + (1 << levels) <= low[axis]) return false;
    }
    return true;
  }
};

}  // namespace uwsim
