#pragma once

#include "uwsim/mapping/bricks/kernels/scan_kernels.h"

/// Converts rays to marked voxels, one ray at a time. At each step a ray crosses the nearest face; on a tie, z comes
/// before y before x, as in OctoMap. Compiled into each scan_kernels_*.cpp with internal linkage; only those files may
/// include this one.
namespace uwsim::bricks {
namespace {

/// The number of voxels, including the first, for which the walk need not test whether the ray has ended. Reaching the
/// voxel of the ray's end takes `steps` steps. Rounding moves a crossing by less than a millionth of the ray's length,
/// which is less than one voxel, so only the last three steps, one along each axis, may come in a different order than
/// in exact geometry.
inline std::uint32_t untested_steps(std::uint32_t steps) { return steps > 4 ? steps - 3 : 1; }

/// The bits to flip in a ray's addresses so that each step adds one, even in a negative direction.
inline std::uint64_t mirror_of(const WalkInput& walk, std::uint32_t negative) {
  return (negative & 1 ? walk.axis_mask[0] : 0) | (negative & 2 ? walk.axis_mask[1] : 0) |
         (negative & 4 ? walk.axis_mask[2] : 0);
}

/// Marks the voxels along a ray, from the one that contains its origin up to, but not including, the one that contains
/// its end. The bits of a word are combined before they are written.
inline void walk_one(const WalkInput& walk, std::uint32_t ray) {
  const Rays& rays = *walk.rays;
  double tx = rays.next[0][ray], ty = rays.next[1][ray], tz = rays.next[2][ray];
  const double dx = rays.stride[0][ray], dy = rays.stride[1][ray], dz = rays.stride[2][ray];
  const double length = rays.length[ray];
  const std::uint64_t mx = walk.axis_mask[0], my = walk.axis_mask[1], mz = walk.axis_mask[2];
  const std::uint64_t mirror = mirror_of(walk, rays.negative[ray]), end = walk.end_address[ray];
  std::uint64_t address = walk.origin_address ^ mirror;
  std::uint64_t word = walk.origin_address >> 6, mask = std::uint64_t{1} << (walk.origin_address & 63);
  const auto write = [&] {
    if (walk.table) {
      walk.table[word] |= mask;
      walk.touched[word >> 3] = 1;
    } else {
      walk.mark(walk.context, word, mask);
    }
  };
  const auto step = [&] {
    const double lower = tx < ty ? tx : ty;
    const bool along_z = !(lower < tz), along_x = tx < ty && !along_z, along_y = !along_x && !along_z;
    const std::uint64_t axis = along_z ? mz : along_x ? mx : my;
    address = (((address | ~axis) + 1) & axis) | (address & ~axis);  // adds one to the bits of the axis
    tx += along_x ? dx : 0.0;
    ty += along_y ? dy : 0.0;
    tz += along_z ? dz : 0.0;
  };
  const auto mark = [&] {
    const std::uint64_t real = address ^ mirror;
    if (real >> 6 != word) {
      write();
      word = real >> 6;
      mask = 0;
    }
    mask |= std::uint64_t{1} << (real & 63);
  };
  for (std::uint32_t k = untested_steps(rays.steps[ray]); k > 1; --k) {
    step();
    mark();
  }
  for (;;) {
    step();
    const double lower = tx < ty ? tx : ty;
    if (address == end || (lower < tz ? lower : tz) > length) break;
    mark();
  }
  write();
}

inline void walk_one_by_one(const WalkInput& in) {
  for (std::size_t i = 0; i < in.count; ++i) walk_one(in, in.order[i]);
}

}  // namespace
}  // namespace uwsim::bricks
