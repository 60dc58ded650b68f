#pragma once

#include "uwsim/mapping/bricks/kernels/ray_walk.h"
#include "uwsim/mapping/bricks/kernels/slab_setup.h"
#include "uwsim/mapping/bricks/kernels/slab_tiles.h"

/// Walks the rays that slab_setup.h selects. Compiled into each scan_kernels_slabs_*.cpp.
namespace uwsim::bricks {
namespace {

/// As many rays as there are lanes, with the same heading, walked slab by slab (slab_setup.h). Tile addresses are
/// mirrored, so that every step adds one. Tile masks are not mirrored: their bits are those of the actual voxels.
class SlabWalk {
 public:
  SlabWalk(const SlabInput& in, const WalkInput& walk, const SlabHeading& heading, const std::uint32_t* rays,
           LaneMask lanes)
      : heading_(heading), lanes_(lanes) {
    const Lanes index = load(rays);
    const auto column = [&](const std::uint32_t* from) { return gather(from, index); };
    slope_ = column(in.slab_rays->slope);
    fraction_ = column(in.slab_rays->fraction);
    minor_slab_ = column(in.slab_rays->minor_slab);
    minor_fraction_ = column(in.slab_rays->minor_fraction);
    minor_slabs_ = column(in.slab_rays->minor_slabs);
    minor_slabs_fraction_ = column(in.slab_rays->minor_slabs_fraction);
    minor_middle_ = column(in.slab_rays->minor_middle);
    minor_middles_ = column(in.slab_rays->minor_middles);
    slabs_ = only(lanes, column(in.slab_rays->slabs));
    flags_ = column(in.slab_rays->flags);
    alignas(64) std::uint32_t mirrors[kLanes], ends[kLanes], downs[kLanes];
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const std::uint32_t negative = walk.rays->negative[rays[lane]], slabs = in.slab_rays->slabs[rays[lane]];
      mirrors[lane] = static_cast<std::uint32_t>(mirror_of(walk, negative));
      ends[lane] = static_cast<std::uint32_t>(walk.end_address[rays[lane]]);
      downs[lane] = negative >> heading.b & 1;
      longest_ = slabs > longest_ ? slabs : longest_;
    }
    mirror_ = load(mirrors);
    end_ = load(ends);
    down_b_ = is_equal(load(downs), all_lanes(1));
    tile_bits_ = all_lanes(heading.tile_a | heading.tile_b | heading.mask_z);
    tile_ = (all_lanes(heading.origin) ^ mirror_) & tile_bits_;
    const Lanes bit = all_lanes(1u << (4 * heading.at_b + heading.at_a));
    bit_ = select(down_b_, shift_up<16>(bit), bit);
    step_b_ = select(down_b_, all_lanes(28), all_lanes(4));
    alignas(64) std::uint32_t before[kLanes] = {};
    for (std::uint32_t slabs = 0; slabs < kLanes; ++slabs) {
      const std::uint32_t passed = slabs < 4 ? slabs : 4, bits = (1u << passed) - 1;
      before[slabs] = 0x11111111u * (heading.down ? bits << (4 - passed) : bits);
    }
    before_ = load(before);
  }

  /// Marks the voxels of the rays. Returns false if the path of one of them is uncertain; the marks written so far are
  /// then correct but incomplete.
  bool walk(TileMarks& marks, MarkBuffer& buffer) {
    return heading_.down ? walk_along<true>(marks, buffer) : walk_along<false>(marks, buffer);
  }

 private:
  template <bool kDown>
  bool walk_along(TileMarks& marks, MarkBuffer& buffer) {
    marks.clear();
    const int longest = static_cast<int>(longest_);
    Lanes mask = all_lanes(0);
    mark_slab<kDown>(mask, has_any(flags_, all_lanes(kMiddleInFirstSlab)));
    for (int slab = heading_.passed_slabs + 1; slab < 4; ++slab) mark_slab<kDown>(mask, next_slab());
    finish_tile<kDown>(-heading_.passed_slabs, mask, marks);
    for (int first = 4 - heading_.passed_slabs; first < longest; first += 4) {
      mask = all_lanes(0);
      for (int slab = 0; slab < 4; ++slab) mark_slab<kDown>(mask, next_slab());
      finish_tile<kDown>(first, mask, marks);
      if (marks.count() < TileMarks::kCapacity) continue;
      if (!is_certain()) return false;
      marks.write(heading_, buffer);
    }
    if (!is_certain()) return false;
    marks.write(heading_, buffer);
    mark_last_slab(buffer);
    return true;
  }

  /// Proceeds to the next slab; returns a mask of the rays that cross a face across b in it.
  LaneMask next_slab() {
    fraction_ = plus(fraction_, slope_);
    least_fraction_ = smaller(least_fraction_, fraction_);
    return is_less(fraction_, slope_);
  }

  /// Marks the voxels of one slab: one voxel, or two if the ray crosses a face across b.
  template <bool kDown>
  void mark_slab(Lanes& mask, LaneMask crossing) {
    const Lanes next = select(crossing, rotate_each_up(bit_, step_b_), bit_);
    mask = join(mask, bit_, next);
    bit_ = rotate_up < kDown ? 31 : 1 > (next);
  }

  /// Called when four slabs, starting with `first`, have been marked in `mask`. Adds the marks to the tiles at the
  /// right levels of z and proceeds to the next tile.
  template <bool kDown>
  void finish_tile(int first, Lanes mask, TileMarks& marks) {
    bit_ = rotate_up < kDown ? 4 : 28 > (bit_);
    const Lanes start = all_lanes(static_cast<std::uint32_t>(first)), four = all_lanes(4);
    mask = mask & look_up(before_, smaller(not_negative(minus(slabs_, start)), four));
    const Lanes next_b = add_one(tile_, all_lanes(heading_.tile_b));
    const Lanes low = select(down_b_, next_b, tile_);
    const Lanes minor_at = minus(minor_slab_, start);
    const LaneMask climbs = is_less(minor_at, four);
    if (any(climbs)) {
      Lanes below, above;
      split(mask, minor_at, climbs, below, above);
      const Lanes change = tile_ ^ add_one(tile_, all_lanes(heading_.mask_z));
      marks.add(real(low), below);
      marks.add(select(climbs, real(low ^ change), all_lanes(~0u)), above);
      tile_ = tile_ ^ only(climbs, change);
      cross_minor(climbs);
    } else {
      marks.add(real(low), mask);
    }
    const Lanes near = select(down_b_, all_lanes(0xffff0000), all_lanes(0xffff));
    const LaneMask in_next_b = has_none(bit_, near);
    const Lanes moved = blend(all_lanes(heading_.tile_b), next_b, tile_);
    tile_ = add_one(select(in_next_b, moved, tile_), all_lanes(heading_.tile_a));
    bit_ = select(in_next_b, rotate_up<16>(bit_), bit_);
  }

  /// Returns the address of a tile without mirroring.
  Lanes real(Lanes tile) const { return differences(tile, mirror_, tile_bits_); }

  /// Splits the marks of rays that cross a face across z in slab `at` of the tile into those before and those after the
  /// crossing. The voxel where the ray crosses belongs to both. The slab of that voxel may contain a second voxel,
  /// before or after it along b.
  void split(Lanes mask, Lanes at, LaneMask climbs, Lanes& before, Lanes& after) const {
    const Lanes until = look_up(before_, at), through = look_up(before_, plus(at, all_lanes(1)));
    const Lanes slab = mask & without(through, until);
    const Lanes odd = sign(minor_middle_) ^ all_lanes(0x0f0f0f0f);
    const Lanes both = slab & odd, other = without(slab, odd);
    const LaneMask early = is_less(other, both) ^ down_b_;
    before = select(climbs, (mask & until) | both | only(early, other), mask);
    after = only(climbs, without(mask, through) | both | without(other, early));
  }

  /// Proceeds to the next face across z.
  void cross_minor(LaneMask climbs) {
    least_middle_ = select(climbs, smaller(least_middle_, shift_up<1>(minor_middle_)), least_middle_);
    minor_middle_ = plus(climbs, minor_middle_, minor_middles_);
    minor_fraction_ = plus(climbs, minor_fraction_, minor_slabs_fraction_);
    least_fraction_ = smaller(least_fraction_, minor_fraction_);
    const LaneMask carry = climbs & is_less(minor_fraction_, minor_slabs_fraction_);
    minor_slab_ = plus(carry, plus(climbs, minor_slab_, minor_slabs_), all_lanes(1));
  }

  /// Whether all crossings so far were farther apart than the tolerance.
  bool is_certain() const {
    const Lanes twice = shift_up<1>(tolerance_of(slabs_));
    const LaneMask doubts = is_less(least_fraction_, twice) | is_less(least_middle_, shift_up<1>(twice));
    return !any(doubts & lanes_);
  }

  /// Marks the voxels in the last slab, except the voxel of the ray's end.
  void mark_last_slab(MarkBuffer& buffer) const {
    const auto flagged = [&](SlabFlag flag) { return has_any(flags_, all_lanes(flag)); };
    const LaneMask b = flagged(kMiddleInLastSlab), z = flagged(kMinorInLastSlab);
    const Lanes less_b = subtract_one(end_, all_lanes(heading_.mask_b));
    const Lanes less_z = subtract_one(end_, all_lanes(heading_.mask_z));
    const Lanes between = select(flagged(kMiddleBeforeMinor), less_z, less_b);
    const Lanes less_both = subtract_one(less_b, all_lanes(heading_.mask_z));
    const Lanes entered = select(b & z, less_both, select(z, less_z, less_b));
    std::size_t marks = mark_voxels(buffer, 0, lanes_ & (b | z), entered);
    marks = mark_voxels(buffer, marks, lanes_ & b & z, between);
    buffer.write(marks);
  }

  std::size_t mark_voxels(MarkBuffer& buffer, std::size_t marks, LaneMask which, Lanes address) const {
    const Lanes voxel = address ^ mirror_;
    return buffer.append(marks, which, shift_down<5>(voxel), bit_of_each(voxel));
  }

  const SlabHeading& heading_;
  const LaneMask lanes_;
  LaneMask down_b_;     ///< mask of rays that run in the negative direction of b
  Lanes mirror_, end_;  ///< as in WalkInput
  /// Mirrored address of the tile that each ray is in; the bits of an address that select a tile
  Lanes tile_, tile_bits_;
  /// Bit of the voxel that each ray is in; how far this bit is rotated when the ray crosses a face across b
  Lanes bit_, step_b_;
  Lanes before_;                            ///< [n]: bits of the first n slabs of a tile
  Lanes slabs_, flags_, slope_, fraction_;  ///< as in SlabRays, then advanced
  Lanes minor_slab_, minor_fraction_, minor_slabs_, minor_slabs_fraction_, minor_middle_, minor_middles_;
  Lanes least_fraction_ = all_lanes(~0u), least_middle_ = all_lanes(~0u);  ///< smallest so far
  std::uint32_t longest_ = 0;                                              ///< most slabs of any ray
};

inline void walk_slabs(const SlabInput& in, const WalkInput& walk) {
  MarkBuffer buffer(walk);
  TileMarks marks;
  for (unsigned h = 1; h <= 4; ++h) {
    const SlabHeading heading(walk, h);
    for (std::size_t i = in.first[h - 1]; i < in.first[h]; i += kLanes) {
      const std::size_t count = in.first[h] - i < kLanes ? in.first[h] - i : kLanes;
      alignas(64) std::uint32_t rays[kLanes];
      for (std::size_t lane = 0; lane < kLanes; ++lane) rays[lane] = in.order[i + (lane < count ? lane : count - 1)];
      if (SlabWalk(in, walk, heading, rays, first_lanes(count)).walk(marks, buffer)) continue;
      for (std::size_t lane = 0; lane < count; ++lane) walk_one(walk, rays[lane]);
    }
  }
}

}  // namespace
}  // namespace uwsim::bricks
