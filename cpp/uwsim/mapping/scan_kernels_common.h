#pragma once

#include "uwsim/mapping/scan_kernels.h"

/// What the forms of the kernels share, compiled once for each, with internal linkage. Only the files named
/// scan_kernels_*.cpp may include it.
namespace uwsim::bricks {
namespace {

/// Untested steps of a ray: its last three, one an axis, may come in another order than geometry has them, by rounding.
/// Up to there no voxel can be the last one: it takes `steps` steps to get to the end's, and rounding moves a crossing
/// by less than a millionth of the ray's length, which is less than one voxel.
inline std::uint32_t untested(std::uint32_t steps) { return steps > 4 ? steps - 3 : 1; }

struct Aim {
  float end_m[3];
  float direction[3];
  float length_m;
};

/// OctoMap's arithmetic, step by step: OccupancyOcTreeBase::computeUpdate, then OcTreeBaseImpl::computeRayKeys.
inline Kind aim_at(const float point_m[3], const float origin_m[3], double max_range_m, Aim& aim) {
  const float dx = point_m[0] - origin_m[0], dy = point_m[1] - origin_m[1], dz = point_m[2] - origin_m[2];
  const float square = dx * dx + dy * dy + dz * dz;
  const double distance = __builtin_sqrt(static_cast<double>(square));
  const float delta[3] = {dx, dy, dz};
  if (max_range_m < 0 || distance <= max_range_m) {
    // Closer than a float's square can tell is at the origin: OctoMap's own loop might not end.
    for (int axis = 0; axis < 3; ++axis) aim.end_m[axis] = square == 0 ? origin_m[axis] : point_m[axis];
    aim.length_m = static_cast<float>(distance);
    for (int axis = 0; axis < 3; ++axis) aim.direction[axis] = delta[axis] / aim.length_m;
    return kHit;
  }
  const float norm = static_cast<float>(distance), reach = static_cast<float>(max_range_m);
  for (int axis = 0; axis < 3; ++axis) aim.end_m[axis] = origin_m[axis] + delta[axis] / norm * reach;
  const float ex = aim.end_m[0] - origin_m[0], ey = aim.end_m[1] - origin_m[1], ez = aim.end_m[2] - origin_m[2];
  const float cut[3] = {ex, ey, ez};
  aim.length_m = static_cast<float>(__builtin_sqrt(static_cast<double>(ex * ex + ey * ey + ez * ez)));
  for (int axis = 0; axis < 3; ++axis) aim.direction[axis] = cut[axis] / aim.length_m;
  return kPassing;
}

[[maybe_unused]] inline void start_rays(const ScanInput& scan, const Rays& rays) {
  constexpr double kFar = 1.7976931348623157e308;  // the greatest double, as there
  const double factor = 1.0 / scan.resolution_m, resolution = scan.resolution_m;
  int origin_key[3];
  for (int axis = 0; axis < 3; ++axis) {
    origin_key[axis] = static_cast<int>(__builtin_floor(factor * static_cast<double>(scan.origin_m[axis]))) + 32768;
  }
  const float half = static_cast<float>(resolution * 0.5);  // rounded, as there
  for (std::size_t i = 0; i < scan.count; ++i) {
    float point_m[3];
    bool finite = true;
    for (int axis = 0; axis < 3; ++axis) {
      const float world_m = scan.points_world_m[3 * i + static_cast<std::size_t>(axis)];
      finite = finite && __builtin_fabsf(world_m) <= 3.402823466e+38f;
      point_m[axis] = static_cast<float>(static_cast<double>(world_m) - scan.tree_origin_world_m[axis]);
    }
    rays.steps[i] = 0;
    rays.kind[i] = kSkipped;
    for (int axis = 0; axis < 3; ++axis) rays.end_key[axis][i] = static_cast<std::uint16_t>(origin_key[axis]);
    if (!finite) continue;
    Aim aim;
    rays.kind[i] = aim_at(point_m, scan.origin_m, scan.max_range_m, aim);
    rays.length[i] = static_cast<double>(aim.length_m);
    std::uint32_t steps = 0, negative = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const int key = static_cast<int>(__builtin_floor(factor * static_cast<double>(aim.end_m[axis]))) + 32768;
      rays.end_key[axis][i] = static_cast<std::uint16_t>(key);
      steps += static_cast<std::uint32_t>(key > origin_key[axis] ? key - origin_key[axis] : origin_key[axis] - key);
      const double direction = static_cast<double>(aim.direction[axis]);
      const double middle = (static_cast<double>(origin_key[axis] - 32768) + 0.5) * resolution;
      const double border = direction < 0 ? middle - static_cast<double>(half) : middle + static_cast<double>(half);
      const bool moves = direction > 0 || direction < 0;
      rays.next[axis][i] = moves ? (border - static_cast<double>(scan.origin_m[axis])) / direction : kFar;
      rays.stride[axis][i] = moves ? resolution / __builtin_fabs(direction) : kFar;
      negative |= static_cast<std::uint32_t>(direction < 0) << axis;
    }
    rays.steps[i] = steps;
    rays.negative[i] = static_cast<std::uint8_t>(negative);
  }
}

inline std::uint64_t mirror_of(const WalkInput& walk, std::uint32_t negative) {
  return (negative & 1 ? walk.axis_mask[0] : 0) | (negative & 2 ? walk.axis_mask[1] : 0) |
         (negative & 4 ? walk.axis_mask[2] : 0);
}

/// One after the other, gathering the bits of a word before they are put down.
inline void walk_one(const WalkInput& walk, std::uint32_t ray) {
  const Rays& rays = *walk.rays;
  double tx = rays.next[0][ray], ty = rays.next[1][ray], tz = rays.next[2][ray];
  const double dx = rays.stride[0][ray], dy = rays.stride[1][ray], dz = rays.stride[2][ray];
  const double length = rays.length[ray];
  const std::uint64_t mx = walk.axis_mask[0], my = walk.axis_mask[1], mz = walk.axis_mask[2];
  const std::uint64_t mirror = mirror_of(walk, rays.negative[ray]), end = walk.end_address[ray];
  std::uint64_t address = walk.origin_address ^ mirror;
  std::uint64_t word = walk.origin_address >> 6, mask = std::uint64_t{1} << (walk.origin_address & 63);
  const auto put = [&] {
    if (walk.table) {
      walk.table[word] |= mask;
      walk.touched[word >> 3] = 1;
    } else {
      walk.put(walk.context, word, mask);
    }
  };
  const auto step = [&] {
    const double lower = tx < ty ? tx : ty;
    const bool along_z = !(lower < tz), along_x = tx < ty && !along_z, along_y = !along_x && !along_z;
    const std::uint64_t axis = along_z ? mz : along_x ? mx : my;
    address = (((address | ~axis) + 1) & axis) | (address & ~axis);
    tx += along_x ? dx : 0.0;
    ty += along_y ? dy : 0.0;
    tz += along_z ? dz : 0.0;
  };
  const auto mark = [&] {
    const std::uint64_t real = address ^ mirror;
    if (real >> 6 != word) {
      put();
      word = real >> 6;
      mask = 0;
    }
    mask |= std::uint64_t{1} << (real & 63);
  };
  for (std::uint32_t k = untested(rays.steps[ray]); k > 1; --k) {
    step();
    mark();
  }
  for (;;) {
    step();
    const double lower = tx < ty ? tx : ty;
    if (address == end || (lower < tz ? lower : tz) > length) break;
    mark();
  }
  put();
}

/// Ops::compress writes the words that are not zero and tells which they were.
template <typename Ops>
inline Collected collect_chunk(const CollectInput& in) {
  Collected n{0, 0};
  for (std::size_t first = 0; first < 512; first += 64) {
    for (std::uint64_t bits = Ops::touched(in.touched + first); bits != 0; bits &= bits - 1) {
      const std::size_t brick = first + static_cast<std::size_t>(__builtin_ctzll(bits));
      std::uint64_t* const free = in.free_table + 8 * brick;
      Entry entry{static_cast<std::uint16_t>(brick), 0, 0};
      std::uint64_t* const hit = in.hit_table + 8 * brick;
      const bool has_hits = in.touched[brick] & 2;
      if (has_hits) {
        for (int w = 0; w < 8; ++w) free[w] &= ~hit[w];  // a hit beats a miss
      }
      entry.free_words = Ops::compress(free, in.masks + n.masks);
      n.masks += static_cast<std::size_t>(__builtin_popcount(entry.free_words));
      if (has_hits) {
        entry.hit_words = Ops::compress(hit, in.masks + n.masks);
        n.masks += static_cast<std::size_t>(__builtin_popcount(entry.hit_words));
      }
      in.entries[n.entries++] = entry;
    }
    Ops::wipe(in.touched + first);
  }
  return n;
}

inline float clamped(float value, const SensorModel& model) {
  return value < model.lowest ? model.lowest : value > model.highest ? model.highest : value;
}

/// The block of a word that is about to change. Ops::fill(block, bits, value): value where there are bits, else zero.
template <typename Ops>
inline float* block_of(Brick& brick, int word, const UpdateInput& in) {
  if (brick.block[word] == kNone) {
    brick.block[word] = in.blocks->free[--in.blocks->free_count];
    Ops::fill(in.blocks->at(brick.block[word]), brick.known[word], in.model.lowest);
  }
  return in.blocks->at(brick.block[word]);
}

/// OctoMap's updateNode for each bit: nothing for a known voxel at the limit, else add and clamp.
template <typename Ops>
inline void hit_word(Brick& brick, int word, std::uint64_t hits, const UpdateInput& in) {
  float* const block = block_of<Ops>(brick, word, in);
  for (std::uint64_t bits = hits; bits != 0; bits &= bits - 1) {
    const std::uint64_t bit = bits & -bits;
    float& value = block[__builtin_ctzll(bits)];
    if (brick.known[word] & bit) {
      if (value >= in.model.highest || (in.model.hit == 0 && value <= in.model.lowest)) continue;
    }
    value = clamped(value + in.model.hit, in.model);
    brick.low[word] = value <= in.model.lowest ? brick.low[word] | bit : brick.low[word] & ~bit;
  }
  brick.known[word] |= hits;
}

/// Ops::miss(block, todo, model) adds misses and tells which voxels are at or below the lowest after it;
/// Ops::all_equal(block, bits, value).
template <typename Ops>
inline void update_bricks(const UpdateInput& in) {
  const std::uint64_t* masks = in.masks;
  for (std::size_t i = 0; i < in.count; ++i) {
    const Entry entry = in.entries[i];
    const std::uint64_t* const mask = masks;
    masks += __builtin_popcount(entry.free_words) + __builtin_popcount(entry.hit_words);
    in.emptied[i] = 0;
    if (!in.bricks[i]) continue;
    Brick& brick = *in.bricks[i];
    int at = 0;
    for (unsigned words = entry.free_words; words != 0; words &= words - 1) {
      const int word = __builtin_ctz(words);
      const std::uint64_t free = mask[at++];
      // A miss of no weight changes only what was unknown.
      const std::uint64_t todo = free & ~(in.model.miss < 0 ? brick.low[word] : brick.known[word]);
      if (todo == 0) continue;
      float* const block = block_of<Ops>(brick, word, in);
      brick.low[word] |= Ops::miss(block, todo, in.model);
      brick.known[word] |= todo;
      if (brick.low[word] == brick.known[word] && Ops::all_equal(block, brick.known[word], in.model.lowest)) {
        in.blocks->free[in.blocks->free_count++] = brick.block[word];
        brick.block[word] = kNone;
        in.emptied[i] = 1;
      }
    }
    for (unsigned words = entry.hit_words; words != 0; words &= words - 1) {
      hit_word<Ops>(brick, __builtin_ctz(words), mask[at++], in);
    }
  }
}

}  // namespace
}  // namespace uwsim::bricks
