#include <immintrin.h>

#include "uwsim/mapping/bricks/kernels/ray_walk.h"
#include "uwsim/mapping/bricks/kernels/slab_setup_avx512.h"
#include "uwsim/mapping/bricks/kernels/slab_tiles_avx512.h"

namespace uwsim::bricks {
namespace {

/// Sixteen rays with the same heading, walked slab by slab (slab_setup_avx512.h). Tile addresses are mirrored, so that
/// every step adds one. Tile masks are not mirrored: their bits are those of the actual voxels.
class SixteenSlabRays {
 public:
  SixteenSlabRays(const SlabInput& in, const WalkInput& walk, const SlabHeading& heading, const std::uint32_t* rays,
                  __mmask16 lanes)
      : heading_(heading), lanes_(lanes) {
    const __m512i index = _mm512_loadu_si512(rays);
    const auto column = [&](const std::uint32_t* from) { return _mm512_i32gather_epi32(index, from, 4); };
    slope_ = column(in.slab_rays->slope);
    fraction_ = column(in.slab_rays->fraction);
    minor_slab_ = column(in.slab_rays->minor_slab);
    minor_fraction_ = column(in.slab_rays->minor_fraction);
    minor_slabs_ = column(in.slab_rays->minor_slabs);
    minor_slabs_fraction_ = column(in.slab_rays->minor_slabs_fraction);
    minor_middle_ = column(in.slab_rays->minor_middle);
    minor_middles_ = column(in.slab_rays->minor_middles);
    slabs_ = _mm512_maskz_mov_epi32(lanes, column(in.slab_rays->slabs));
    flags_ = column(in.slab_rays->flags);
    alignas(64) std::uint32_t mirrors[16], ends[16];
    __mmask16 down_b = 0;
    for (int lane = 0; lane < 16; ++lane) {
      const std::uint32_t negative = walk.rays->negative[rays[lane]];
      mirrors[lane] = static_cast<std::uint32_t>(mirror_of(walk, negative));
      ends[lane] = static_cast<std::uint32_t>(walk.end_address[rays[lane]]);
      down_b = static_cast<__mmask16>(down_b | (negative >> heading.b & 1) << lane);
    }
    mirror_ = _mm512_load_si512(mirrors);
    end_ = _mm512_load_si512(ends);
    down_b_ = down_b;
    tile_bits_ = all_lanes(heading.tile_a | heading.tile_b | heading.mask_z);
    tile_ = _mm512_and_si512(_mm512_xor_si512(all_lanes(heading.origin), mirror_), tile_bits_);
    const __m512i bit = all_lanes(1u << (4 * heading.at_b + heading.at_a));
    bit_ = _mm512_mask_slli_epi32(bit, down_b, bit, 16);
    step_b_ = _mm512_mask_mov_epi32(_mm512_set1_epi32(4), down_b, _mm512_set1_epi32(28));
    alignas(64) std::uint32_t before[16] = {};
    for (std::uint32_t slabs = 0; slabs < 16; ++slabs) {
      const std::uint32_t passed = slabs < 4 ? slabs : 4, bits = (1u << passed) - 1;
      before[slabs] = 0x11111111u * (heading.down ? bits << (4 - passed) : bits);
    }
    before_ = _mm512_load_si512(before);
  }

  /// Marks the voxels of the rays. Returns false if the path of one of them is uncertain; the marks written so far are
  /// then correct but incomplete.
  bool walk(TileMarks& marks, MarkBuffer& buffer) {
    marks.clear();
    const int longest = _mm512_reduce_max_epi32(slabs_);
    __m512i mask = _mm512_setzero_si512();
    mark_slab(mask, _mm512_test_epi32_mask(flags_, all_lanes(kMiddleInFirstSlab)));
    for (int slab = heading_.passed_slabs + 1; slab < 4; ++slab) mark_slab(mask, next_slab());
    finish_tile(-heading_.passed_slabs, mask, marks);
    for (int first = 4 - heading_.passed_slabs; first < longest; first += 4) {
      mask = _mm512_setzero_si512();
      for (int slab = 0; slab < 4; ++slab) mark_slab(mask, next_slab());
      finish_tile(first, mask, marks);
      if (marks.count() < TileMarks::kCapacity) continue;
      if (!is_certain()) return false;
      marks.write(heading_, buffer);
    }
    if (!is_certain()) return false;
    marks.write(heading_, buffer);
    mark_last_slab(buffer);
    return true;
  }

 private:
  /// Proceeds to the next slab; returns a mask of the rays that cross a face across b in it.
  __mmask16 next_slab() {
    fraction_ = _mm512_add_epi32(fraction_, slope_);
    least_fraction_ = _mm512_min_epu32(least_fraction_, fraction_);
    return _mm512_cmplt_epu32_mask(fraction_, slope_);
  }

  /// Marks the voxels of one slab: one voxel, or two if the ray crosses a face across b.
  void mark_slab(__m512i& mask, __mmask16 crossing) {
    const __m512i next = _mm512_mask_rolv_epi32(bit_, crossing, bit_, step_b_);
    mask = _mm512_ternarylogic_epi32(mask, bit_, next, 0xfe);  // mask | bit_ | next
    bit_ = heading_.down ? _mm512_ror_epi32(next, 1) : _mm512_rol_epi32(next, 1);
  }

  /// Called when four slabs, starting with `first`, have been marked in `mask`. Adds the marks to the tiles at the
  /// right levels of z and proceeds to the next tile.
  void finish_tile(int first, __m512i mask, TileMarks& marks) {
    bit_ = heading_.down ? _mm512_rol_epi32(bit_, 4) : _mm512_ror_epi32(bit_, 4);
    const __m512i start = _mm512_set1_epi32(first);
    const __m512i left = _mm512_max_epi32(_mm512_sub_epi32(slabs_, start), _mm512_setzero_si512());
    mask = _mm512_and_si512(mask, _mm512_permutexvar_epi32(_mm512_min_epi32(left, all_lanes(4)), before_));
    const __m512i next_b = add_one(tile_, all_lanes(heading_.tile_b));
    const __m512i low = _mm512_mask_mov_epi32(tile_, down_b_, next_b);
    const __m512i minor_at = _mm512_sub_epi32(minor_slab_, start);
    const __mmask16 climbs = _mm512_cmplt_epu32_mask(minor_at, all_lanes(4));
    __m512i below = mask, above = _mm512_setzero_si512();
    if (climbs) {
      split(mask, minor_at, climbs, below, above);
      const __m512i change = _mm512_xor_si512(tile_, add_one(tile_, all_lanes(heading_.mask_z)));
      marks.add(real(low), below);
      marks.add(_mm512_mask_mov_epi32(all_lanes(~0u), climbs, real(_mm512_xor_si512(low, change))), above);
      tile_ = _mm512_mask_xor_epi32(tile_, climbs, tile_, change);
      cross_minor(climbs);
    } else {
      marks.add(real(low), below);
    }
    const __m512i near = _mm512_mask_mov_epi32(all_lanes(0xffff), down_b_, all_lanes(0xffff0000));
    const __mmask16 in_next_b = _mm512_testn_epi32_mask(bit_, near);
    const __m512i moved = _mm512_ternarylogic_epi32(all_lanes(heading_.tile_b), next_b, tile_, 0xca);
    tile_ = add_one(_mm512_mask_mov_epi32(tile_, in_next_b, moved), all_lanes(heading_.tile_a));
    bit_ = _mm512_mask_rol_epi32(bit_, in_next_b, bit_, 16);
  }

  /// Returns the address of a tile without mirroring.
  __m512i real(__m512i tile) const { return _mm512_ternarylogic_epi32(tile, mirror_, tile_bits_, 0x28); }

  /// Splits the marks of rays that cross a face across z in slab `at` of the tile into those before and those after the
  /// crossing. The voxel where the ray crosses belongs to both. The slab of that voxel may contain a second voxel,
  /// before or after it along b.
  void split(__m512i mask, __m512i at, __mmask16 climbs, __m512i& before, __m512i& after) const {
    const __m512i until = _mm512_permutexvar_epi32(at, before_);
    const __m512i through = _mm512_permutexvar_epi32(_mm512_add_epi32(at, all_lanes(1)), before_);
    const __m512i slab = _mm512_and_si512(mask, _mm512_andnot_si512(until, through));
    const __m512i odd = _mm512_xor_si512(_mm512_srai_epi32(minor_middle_, 31), all_lanes(0x0f0f0f0f));
    const __m512i both = _mm512_and_si512(slab, odd), other = _mm512_andnot_si512(odd, slab);
    const __mmask16 early = static_cast<__mmask16>(_mm512_cmplt_epu32_mask(other, both) ^ down_b_);
    before = _mm512_mask_or_epi32(mask, climbs, _mm512_and_si512(mask, until), both);
    before = _mm512_mask_or_epi32(before, static_cast<__mmask16>(climbs & early), before, other);
    after = _mm512_maskz_or_epi32(climbs, _mm512_andnot_si512(through, mask), both);
    after = _mm512_mask_or_epi32(after, static_cast<__mmask16>(climbs & ~early), after, other);
  }

  /// Proceeds to the next face across z.
  void cross_minor(__mmask16 climbs) {
    least_middle_ = _mm512_mask_min_epu32(least_middle_, climbs, least_middle_, _mm512_slli_epi32(minor_middle_, 1));
    minor_middle_ = _mm512_mask_add_epi32(minor_middle_, climbs, minor_middle_, minor_middles_);
    minor_fraction_ = _mm512_mask_add_epi32(minor_fraction_, climbs, minor_fraction_, minor_slabs_fraction_);
    least_fraction_ = _mm512_min_epu32(least_fraction_, minor_fraction_);
    const __mmask16 carry = _mm512_mask_cmplt_epu32_mask(climbs, minor_fraction_, minor_slabs_fraction_);
    minor_slab_ = _mm512_mask_add_epi32(minor_slab_, climbs, minor_slab_, minor_slabs_);
    minor_slab_ = _mm512_mask_add_epi32(minor_slab_, carry, minor_slab_, all_lanes(1));
  }

  /// Whether all crossings so far were farther apart than the tolerance.
  bool is_certain() const {
    const __m512i twice = _mm512_slli_epi32(tolerance_of(slabs_), 1);
    const __mmask16 doubts = _mm512_cmplt_epu32_mask(least_fraction_, twice) |
                             _mm512_cmplt_epu32_mask(least_middle_, _mm512_slli_epi32(twice, 1));
    return !(doubts & lanes_);
  }

  /// Marks the voxels in the last slab, except the voxel of the ray's end.
  void mark_last_slab(MarkBuffer& buffer) const {
    const auto flagged = [&](SlabFlag flag) { return _mm512_mask_test_epi32_mask(lanes_, flags_, all_lanes(flag)); };
    const __mmask16 b = flagged(kMiddleInLastSlab), z = flagged(kMinorInLastSlab),
                    b_first = flagged(kMiddleBeforeMinor);
    const __m512i less_b = subtract_one(end_, all_lanes(heading_.mask_b));
    const __m512i less_z = subtract_one(end_, all_lanes(heading_.mask_z));
    const __m512i between = _mm512_mask_mov_epi32(less_b, b_first, less_z);
    const __m512i less_both = subtract_one(less_b, all_lanes(heading_.mask_z));
    const __m512i entered =
        _mm512_mask_mov_epi32(_mm512_mask_mov_epi32(less_b, z, less_z), static_cast<__mmask16>(b & z), less_both);
    std::size_t count = mark_voxels(buffer, 0, static_cast<__mmask16>(b | z), entered);
    count = mark_voxels(buffer, count, static_cast<__mmask16>(b & z), between);
    buffer.write(count);
  }

  std::size_t mark_voxels(MarkBuffer& buffer, std::size_t count, __mmask16 which, __m512i address) const {
    const __m512i voxel = _mm512_xor_si512(address, mirror_);
    return buffer.append(count, which, _mm512_srli_epi32(voxel, 5), _mm512_rolv_epi32(all_lanes(1), voxel));
  }

  const SlabHeading& heading_;
  const __mmask16 lanes_;
  __mmask16 down_b_;      ///< mask of rays that run in the negative direction of b
  __m512i mirror_, end_;  ///< as in WalkInput
  /// Mirrored address of the tile that each ray is in; the bits of an address that select a tile
  __m512i tile_, tile_bits_;
  /// Bit of the voxel that each ray is in; how far this bit is rotated when the ray crosses a face across b
  __m512i bit_, step_b_;
  __m512i before_;                            ///< [n]: bits of the first n slabs of a tile
  __m512i slabs_, flags_, slope_, fraction_;  ///< as in SlabRays, then advanced
  __m512i minor_slab_, minor_fraction_, minor_slabs_, minor_slabs_fraction_, minor_middle_, minor_middles_;
  __m512i least_fraction_ = _mm512_set1_epi32(-1), least_middle_ = _mm512_set1_epi32(-1);  ///< smallest so far
};

void walk_slabs(const SlabInput& in, const WalkInput& walk) {
  MarkBuffer buffer(walk);
  TileMarks marks;
  for (unsigned h = 1; h <= 4; ++h) {
    const SlabHeading heading(walk, h);
    for (std::size_t i = in.first[h - 1]; i < in.first[h]; i += 16) {
      const std::size_t count = in.first[h] - i < 16 ? in.first[h] - i : 16;
      const __mmask16 lanes = static_cast<__mmask16>((1u << count) - 1);
      alignas(64) std::uint32_t rays[16];
      for (std::size_t lane = 0; lane < 16; ++lane) rays[lane] = in.order[i + (lane < count ? lane : count - 1)];
      if (SixteenSlabRays(in, walk, heading, rays, lanes).walk(marks, buffer)) continue;
      for (std::size_t lane = 0; lane < count; ++lane) walk_one(walk, rays[lane]);
    }
  }
}

}  // namespace

const SlabKernels kAvx512SlabKernels{set_up_slabs, walk_slabs};

}  // namespace uwsim::bricks
