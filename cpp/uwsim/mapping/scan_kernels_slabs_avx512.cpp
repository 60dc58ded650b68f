#include <immintrin.h>

#include "uwsim/mapping/scan_slab_marks_avx512.h"
#include "uwsim/mapping/scan_slab_rays_avx512.h"

namespace uwsim::bricks {
namespace {

/// Sixteen rays, side by side.
class Sixteen {
 public:
  Sixteen(const SlabInput& in, const WalkInput& walk, const Way& way, const std::uint32_t* rays, __mmask16 lanes)
      : way_(way), walk_(walk), rays_(rays), lanes_(lanes) {
    index_ = _mm512_loadu_si512(rays);
    const auto column = [&](const std::uint32_t* from) { return _mm512_i32gather_epi32(index_, from, 4); };
    slope_ = column(in.to->slope);
    fraction_ = column(in.to->fraction);
    minor_slab_ = column(in.to->minor_slab);
    minor_fraction_ = column(in.to->minor_fraction);
    minor_slabs_ = column(in.to->minor_slabs);
    minor_slabs_fraction_ = column(in.to->minor_slabs_fraction);
    minor_middle_ = column(in.to->minor_middle);
    minor_middles_ = column(in.to->minor_middles);
    slabs_ = _mm512_maskz_mov_epi32(lanes, column(in.to->slabs));
    flags_ = column(in.to->flags);
    alignas(64) std::uint32_t mirrors[16], ends[16];
    __mmask16 back = 0;
    for (int lane = 0; lane < 16; ++lane) {
      const std::uint32_t negative = walk.rays->negative[rays[lane]];
      mirrors[lane] = static_cast<std::uint32_t>(mirror_of(walk, negative));
      ends[lane] = static_cast<std::uint32_t>(walk.end_address[rays[lane]]);
      back = static_cast<__mmask16>(back | (negative >> way.b & 1) << lane);
    }
    mirror_ = _mm512_load_si512(mirrors);
    end_ = _mm512_load_si512(ends);
    back_b_ = back;
    keep_ = set(way.tile_a | way.tile_b | way.mask_z);
    tile_ = _mm512_and_si512(_mm512_xor_si512(set(way.origin), mirror_), keep_);
    bit_ = _mm512_mask_slli_epi32(set(1u << (4 * way.at_b + way.at_a)), back, set(1u << (4 * way.at_b + way.at_a)), 16);
    turn_b_ = _mm512_mask_mov_epi32(_mm512_set1_epi32(4), back, _mm512_set1_epi32(28));
    alignas(64) std::uint32_t before[16] = {};
    for (std::uint32_t slabs = 0; slabs < 16; ++slabs) {
      const std::uint32_t passed = slabs < 4 ? slabs : 4, bits = (1u << passed) - 1;
      before[slabs] = 0x11111111u * (way.back ? bits << (4 - passed) : bits);
    }
    before_ = _mm512_load_si512(before);
  }

  /// False if one of them is not sure of where it goes: those marks that are put are right, not all are there.
  bool walk(Marks& marks, Pending& pending) {
    marks.count = 0;
    const int longest = _mm512_reduce_max_epi32(slabs_);
    __m512i column = _mm512_setzero_si512();
    mark_slab(column, _mm512_test_epi32_mask(flags_, set(kFirst)));
    for (int slab = way_.entry + 1; slab < 4; ++slab) mark_slab(column, advance());
    end_column(-way_.entry, column, marks);
    for (int first = 4 - way_.entry; first < longest; first += 4) {
      column = _mm512_setzero_si512();
      for (int slab = 0; slab < 4; ++slab) mark_slab(column, advance());
      end_column(first, column, marks);
      if (marks.count < Marks::kRoom) continue;
      if (!is_sure()) return false;
      marks.put(way_, pending);
    }
    if (!is_sure()) return false;
    marks.put(way_, pending);
    mark_last_slab(pending);
    return true;
  }

 private:
  static __m512i set(std::uint32_t value) { return _mm512_set1_epi32(static_cast<int>(value)); }

  /// A slab further: which cross a face across b.
  __mmask16 advance() {
    fraction_ = _mm512_add_epi32(fraction_, slope_);
    closest_ = _mm512_min_epu32(closest_, fraction_);
    return _mm512_cmplt_epu32_mask(fraction_, slope_);
  }

  void mark_slab(__m512i& column, __mmask16 crossing) {
    const __m512i next = _mm512_mask_rolv_epi32(bit_, crossing, bit_, turn_b_);
    column = _mm512_ternarylogic_epi32(column, bit_, next, 0xfe);  // or
    bit_ = way_.back ? _mm512_ror_epi32(next, 1) : _mm512_rol_epi32(next, 1);
  }

  /// Four slabs, from `first` on, are done: their marks go where they belong in z.
  void end_column(int first, __m512i column, Marks& marks) {
    bit_ = way_.back ? _mm512_rol_epi32(bit_, 4) : _mm512_ror_epi32(bit_, 4);
    const __m512i start = _mm512_set1_epi32(first);
    const __m512i left = _mm512_max_epi32(_mm512_sub_epi32(slabs_, start), _mm512_setzero_si512());
    column = _mm512_and_si512(column, _mm512_permutexvar_epi32(_mm512_min_epi32(left, set(4)), before_));
    const __m512i next_b = add_one(tile_, set(way_.tile_b));
    const __m512i low = _mm512_mask_mov_epi32(tile_, back_b_, next_b);
    const __m512i minor_at = _mm512_sub_epi32(minor_slab_, start);
    const __mmask16 climbs = _mm512_cmplt_epu32_mask(minor_at, set(4));
    __m512i upper = column, over = _mm512_setzero_si512();
    if (climbs) {
      split(column, minor_at, climbs, upper, over);
      const __m512i change = _mm512_xor_si512(tile_, add_one(tile_, set(way_.mask_z)));
      marks.add(real(low), upper);
      marks.add(_mm512_mask_mov_epi32(set(~0u), climbs, real(_mm512_xor_si512(low, change))), over);
      tile_ = _mm512_mask_xor_epi32(tile_, climbs, tile_, change);
      climb(climbs);
    } else {
      marks.add(real(low), upper);
    }
    const __m512i near = _mm512_mask_mov_epi32(set(0xffff), back_b_, set(0xffff0000));
    const __mmask16 far = _mm512_testn_epi32_mask(bit_, near);
    const __m512i moved = _mm512_ternarylogic_epi32(set(way_.tile_b), next_b, tile_, 0xca);
    tile_ = add_one(_mm512_mask_mov_epi32(tile_, far, moved), set(way_.tile_a));
    bit_ = _mm512_mask_rol_epi32(bit_, far, bit_, 16);
  }

  /// The address of a tile that is not mirrored.
  __m512i real(__m512i tile) const { return _mm512_ternarylogic_epi32(tile, mirror_, keep_, 0x28); }

  /// Marks before and after a face across z is crossed. The voxel where it is has both; in its slab there may be one
  /// more, before it or after it along b.
  void split(__m512i column, __m512i at, __mmask16 climbs, __m512i& before, __m512i& after) const {
    const __m512i until = _mm512_permutexvar_epi32(at, before_);
    const __m512i through = _mm512_permutexvar_epi32(_mm512_add_epi32(at, set(1)), before_);
    const __m512i slab = _mm512_and_si512(column, _mm512_andnot_si512(until, through));
    const __m512i odd = _mm512_xor_si512(_mm512_srai_epi32(minor_middle_, 31), set(0x0f0f0f0f));
    const __m512i both = _mm512_and_si512(slab, odd), other = _mm512_andnot_si512(odd, slab);
    const __mmask16 early = static_cast<__mmask16>(_mm512_cmplt_epu32_mask(other, both) ^ back_b_);
    before = _mm512_mask_or_epi32(column, climbs, _mm512_and_si512(column, until), both);
    before = _mm512_mask_or_epi32(before, static_cast<__mmask16>(climbs & early), before, other);
    after = _mm512_maskz_or_epi32(climbs, _mm512_andnot_si512(through, column), both);
    after = _mm512_mask_or_epi32(after, static_cast<__mmask16>(climbs & ~early), after, other);
  }

  void climb(__mmask16 climbs) {
    closest_middle_ =
        _mm512_mask_min_epu32(closest_middle_, climbs, closest_middle_, _mm512_slli_epi32(minor_middle_, 1));
    minor_middle_ = _mm512_mask_add_epi32(minor_middle_, climbs, minor_middle_, minor_middles_);
    minor_fraction_ = _mm512_mask_add_epi32(minor_fraction_, climbs, minor_fraction_, minor_slabs_fraction_);
    closest_ = _mm512_min_epu32(closest_, minor_fraction_);
    const __mmask16 carry = _mm512_mask_cmplt_epu32_mask(climbs, minor_fraction_, minor_slabs_fraction_);
    minor_slab_ = _mm512_mask_add_epi32(minor_slab_, climbs, minor_slab_, minor_slabs_);
    minor_slab_ = _mm512_mask_add_epi32(minor_slab_, carry, minor_slab_, set(1));
  }

  bool is_sure() const {
    const __m512i twice = _mm512_slli_epi32(slack_of(slabs_), 1);
    const __mmask16 doubts = _mm512_cmplt_epu32_mask(closest_, twice) |
                             _mm512_cmplt_epu32_mask(closest_middle_, _mm512_slli_epi32(twice, 1));
    return !(doubts & lanes_);
  }

  /// In the end's slab: the voxels before it.
  void mark_last_slab(Pending& pending) const {
    const auto flagged = [&](Flag flag) { return _mm512_mask_test_epi32_mask(lanes_, flags_, set(flag)); };
    const __mmask16 b = flagged(kLastMiddle), z = flagged(kLastMinor), b_first = flagged(kLastMiddleFirst);
    const __m512i less_b = take_one(end_, set(way_.mask_b)), less_z = take_one(end_, set(way_.mask_z));
    const __m512i mixed = _mm512_mask_mov_epi32(less_b, b_first, less_z);
    const __m512i less_both = take_one(less_b, set(way_.mask_z));
    const __m512i old =
        _mm512_mask_mov_epi32(_mm512_mask_mov_epi32(less_b, z, less_z), static_cast<__mmask16>(b & z), less_both);
    std::size_t count = mark_voxels(pending, 0, static_cast<__mmask16>(b | z), old);
    count = mark_voxels(pending, count, static_cast<__mmask16>(b & z), mixed);
    pending.put(count);
  }

  std::size_t mark_voxels(Pending& pending, std::size_t at, __mmask16 which, __m512i address) const {
    const __m512i voxel = _mm512_xor_si512(address, mirror_);
    _mm512_storeu_si512(pending.halves + at, _mm512_maskz_compress_epi32(which, _mm512_srli_epi32(voxel, 5)));
    _mm512_storeu_si512(pending.masks + at, _mm512_maskz_compress_epi32(which, _mm512_rolv_epi32(set(1), voxel)));
    return at + static_cast<std::size_t>(__builtin_popcount(which));
  }

  const Way& way_;
  const WalkInput& walk_;
  const std::uint32_t* rays_;
  const __mmask16 lanes_;
  __mmask16 back_b_;
  __m512i index_, mirror_, end_, keep_, before_, slope_, fraction_, slabs_, flags_, tile_, bit_, turn_b_;
  __m512i minor_slab_, minor_fraction_, minor_slabs_, minor_slabs_fraction_, minor_middle_, minor_middles_;
  __m512i closest_ = _mm512_set1_epi32(-1), closest_middle_ = _mm512_set1_epi32(-1);
};

void walk_slabs(const SlabInput& in, const WalkInput& walk) {
  Pending pending;
  pending.table = reinterpret_cast<Pending::HalfWord*>(walk.table);
  pending.touched = walk.touched;
  Marks marks;
  for (unsigned w = 1; w <= 4; ++w) {
    const Way way(walk, w);
    for (std::size_t i = in.first[w - 1]; i < in.first[w]; i += 16) {
      const std::size_t count = in.first[w] - i < 16 ? in.first[w] - i : 16;
      const __mmask16 lanes = static_cast<__mmask16>((1u << count) - 1);
      alignas(64) std::uint32_t rays[16];
      for (std::size_t lane = 0; lane < 16; ++lane) rays[lane] = in.order[i + (lane < count ? lane : count - 1)];
      if (Sixteen(in, walk, way, rays, lanes).walk(marks, pending)) continue;
      for (std::size_t lane = 0; lane < count; ++lane) walk_one(walk, rays[lane]);
    }
  }
}

}  // namespace

const SlabKernels kAvx512SlabKernels{sort_slab_rays, walk_slabs};

}  // namespace uwsim::bricks
