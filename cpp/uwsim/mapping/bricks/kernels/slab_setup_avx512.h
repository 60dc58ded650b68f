#pragma once

#include "uwsim/mapping/bricks/kernels/scan_kernels.h"

/// A faster walk for most rays of a survey, which run mostly along x or y and little along z. The main axis a is x or
/// y, whichever the ray runs along more; the middle axis b is the other of the two; the minor axis is z. A slab is the
/// part of a ray between two faces across a. In one slab, such a ray crosses at most one face across b, and in four
/// slabs, at most one across z.
///
/// The crossings are computed in fixed point, with 2^32 units per voxel and per slab. OctoMap sums t + k d in doubles,
/// with an error of less than k 2^-53 t, which is negligible here. The fixed-point numbers are off by at most one unit
/// per step, so two crossings that are more than tolerance_of(slabs) units apart come in the same order as in OctoMap.
/// Rays with two crossings closer together than that are walked in the same way as OctoMap does it (ray_walk.h).
///
/// This file selects the rays and computes their parameters; scan_kernels_slabs_avx512.cpp walks them. Only the files
/// named scan_kernels_*avx512.cpp may include this file, after <immintrin.h>.
namespace uwsim::bricks {
namespace {

constexpr double kUnits = 4294967296.0;
constexpr double kNever = 1e300;  // stride along an axis along which the ray does not move; longer than any ray
constexpr double kMostSlabs = 16384, kFewestSlabs = 8;
/// Maximum number of faces across z per slab, such that at most one is crossed in four slabs.
constexpr double kSteepest = 0.2499;
constexpr std::uint32_t kNoSlab = 0x40000000;

enum SlabFlag : std::uint32_t {
  kMiddleInFirstSlab = 1,  ///< a face across b is crossed in the first slab
  kMiddleInLastSlab = 2,   ///< a face across b is crossed in the last slab
  kMinorInLastSlab = 4,    ///< a face across z is crossed in the last slab
  kMiddleBeforeMinor = 8,  ///< the last face across b is crossed before the last one across z
};

/// The tolerance, in units, for numbers to which up to `slabs` steps have been added.
__m512d tolerance_of(__m512d slabs) { return _mm512_add_pd(_mm512_add_pd(slabs, slabs), _mm512_set1_pd(64)); }
__m512i tolerance_of(__m512i slabs) { return _mm512_add_epi32(_mm512_slli_epi32(slabs, 1), _mm512_set1_epi32(64)); }

/// Sets up eight rays. d, t and n are the stride, the first crossing and the number of crossings along an axis.
class EightSlabSetups {
 public:
  EightSlabSetups(const SlabInput& in, std::size_t first)
      : in_(in),
        first_(first),
        lanes_(static_cast<__mmask8>(in.count - first < 8 ? (1u << (in.count - first)) - 1 : 255)) {
    const __m512d dx = load(in.rays->stride[0]), dy = load(in.rays->stride[1]);
    const __m512d tx = load(in.rays->next[0]), ty = load(in.rays->next[1]);
    const __m512d nx = steps(0), ny = steps(1);
    along_y_ = _mm512_cmp_pd_mask(dy, dx, _CMP_LT_OQ);
    da_ = _mm512_mask_mov_pd(dx, along_y_, dy);
    db_ = _mm512_mask_mov_pd(dy, along_y_, dx);
    ta_ = _mm512_mask_mov_pd(tx, along_y_, ty);
    tb_ = _mm512_mask_mov_pd(ty, along_y_, tx);
    na_ = _mm512_mask_mov_pd(nx, along_y_, ny);
    nb_ = _mm512_mask_mov_pd(ny, along_y_, nx);
    dz_ = load(in.rays->stride[2]);
    tz_ = load(in.rays->next[2]);
    nz_ = steps(2);
    tolerance_ = tolerance_of(na_);
  }

  void set_up() {
    suited_ = lanes_ & _mm512_cmp_pd_mask(na_, _mm512_set1_pd(kFewestSlabs), _CMP_GE_OQ) &
              _mm512_cmp_pd_mask(na_, _mm512_set1_pd(kMostSlabs), _CMP_LE_OQ);
    check_end();
    set_up_middle();
    set_up_minor();
    store(&SlabRays::slabs, _mm512_cvtpd_epu32(na_));
    store(&SlabRays::flags, flags_);
    const __m128i negative = _mm_maskz_loadu_epi8(lanes_, in_.rays->negative + first_);
    const __mmask8 negative_x = static_cast<__mmask8>(_mm_test_epi8_mask(negative, _mm_set1_epi8(1)));
    const __mmask8 negative_y = static_cast<__mmask8>(_mm_test_epi8_mask(negative, _mm_set1_epi8(2)));
    const __mmask8 down = static_cast<__mmask8>((along_y_ & negative_y) | (~along_y_ & negative_x));
    __m128i heading = _mm_mask_add_epi8(_mm_set1_epi8(1), along_y_, _mm_set1_epi8(1), _mm_set1_epi8(2));
    heading = _mm_mask_add_epi8(heading, down, heading, _mm_set1_epi8(1));
    _mm_mask_storeu_epi8(in_.slab_rays->heading + first_, lanes_, _mm_maskz_mov_epi8(suited_, heading));
  }

 private:
  static __m512d units(__m512d x) { return _mm512_mul_pd(x, _mm512_set1_pd(kUnits)); }
  static __m512d floor(__m512d x) { return _mm512_roundscale_pd(x, _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC); }
  __m512d load(const double* column) const { return _mm512_maskz_loadu_pd(lanes_, column + first_); }
  void store(std::uint32_t* SlabRays::*column, __m256i values) const {
    _mm256_mask_storeu_epi32(in_.slab_rays->*column + first_, lanes_, values);
  }

  __m512d steps(int axis) const {
    const __m256i end = _mm256_cvtepu16_epi32(_mm_maskz_loadu_epi16(lanes_, in_.rays->end_key[axis] + first_));
    const __m256i origin = _mm256_set1_epi32(static_cast<int>(in_.origin_key[axis]));
    return _mm512_cvtepi32_pd(_mm256_abs_epi32(_mm256_sub_epi32(end, origin)));
  }

  /// Returns the fractional part of `x` [voxels or slabs], in units. Rays in `asked` for which `x` is within the
  /// tolerance of an integer are marked unsuitable.
  __m512d certain_fraction(__m512d x, __mmask8 asked) {
    const __m512d fraction = units(_mm512_sub_pd(x, floor(x)));
    const __m512d most = _mm512_sub_pd(_mm512_set1_pd(kUnits), _mm512_add_pd(tolerance_, tolerance_));
    suited_ &= static_cast<__mmask8>(~asked) |
               (_mm512_cmp_pd_mask(x, _mm512_setzero_pd(), _CMP_GE_OQ) &
                _mm512_cmp_pd_mask(fraction, tolerance_, _CMP_GT_OQ) & _mm512_cmp_pd_mask(fraction, most, _CMP_LT_OQ));
    return fraction;
  }

  /// Checks that each ray reaches the voxel of its end and ends there. In a suitable ray, the last crossings along the
  /// three axes are at or before the ray's length, the next crossings are beyond it, and the order of the last
  /// crossings is certain.
  void check_end() {
    const __m512d one = _mm512_set1_pd(1), none = _mm512_set1_pd(-kNever);
    const auto last = [&](__m512d t, __m512d d, __m512d n) {
      const __mmask8 any = _mm512_cmp_pd_mask(n, one, _CMP_GE_OQ);
      return _mm512_mask_mov_pd(none, any, _mm512_add_pd(t, _mm512_mul_pd(d, _mm512_sub_pd(n, one))));
    };
    const auto next = [&](__m512d t, __m512d d, __m512d n) { return _mm512_add_pd(t, _mm512_mul_pd(d, n)); };
    const __m512d a = last(ta_, da_, na_), b = last(tb_, db_, nb_), z = last(tz_, dz_, nz_);
    const __m512d length = load(in_.rays->length), margin = _mm512_mul_pd(length, _mm512_set1_pd(1 / kUnits));
    const __m512d reached = _mm512_add_pd(_mm512_max_pd(a, _mm512_max_pd(b, z)), margin);
    const __m512d beyond = _mm512_min_pd(next(ta_, da_, na_), _mm512_min_pd(next(tb_, db_, nb_), next(tz_, dz_, nz_)));
    const auto apart = [&](__m512d one_crossing, __m512d other) {
      return _mm512_cmp_pd_mask(_mm512_abs_pd(_mm512_sub_pd(one_crossing, other)), margin, _CMP_GT_OQ);
    };
    const __mmask8 late_b = _mm512_cmp_pd_mask(b, a, _CMP_GT_OQ), late_z = _mm512_cmp_pd_mask(z, a, _CMP_GT_OQ);
    suited_ &= _mm512_cmp_pd_mask(reached, beyond, _CMP_LT_OQ) & _mm512_cmp_pd_mask(reached, length, _CMP_LE_OQ) &
               apart(a, b) & apart(a, z) & (static_cast<__mmask8>(~(late_b & late_z)) | apart(b, z));
    flag(late_b, kMiddleInLastSlab);
    flag(late_z, kMinorInLastSlab);
    flag(_mm512_cmp_pd_mask(b, z, _CMP_LT_OQ), kMiddleBeforeMinor);
  }

  void flag(__mmask8 lanes, SlabFlag which) {
    flags_ = _mm256_mask_or_epi32(flags_, lanes, flags_, _mm256_set1_epi32(static_cast<int>(which)));
  }

  /// Computes the number of faces across b that each ray crosses up to the end of the first slab and in each further
  /// slab.
  void set_up_middle() {
    const __mmask8 moves = _mm512_cmp_pd_mask(db_, _mm512_set1_pd(kNever), _CMP_LT_OQ);
    const __m512d slope = _mm512_maskz_div_pd(moves, da_, db_);
    suited_ &= _mm512_cmp_pd_mask(slope, _mm512_set1_pd(1 - 1.0 / 65536), _CMP_LT_OQ);
    const __m512d one = _mm512_set1_pd(1), half = _mm512_set1_pd(0.5);
    const __m512d crossed =
        _mm512_mask_add_pd(half, moves, _mm512_maskz_div_pd(moves, _mm512_sub_pd(ta_, tb_), db_), one);
    const __m512d fraction = certain_fraction(crossed, 0xff);
    suited_ &= _mm512_cmp_pd_mask(crossed, _mm512_set1_pd(2), _CMP_LT_OQ);
    flag(_mm512_cmp_pd_mask(crossed, one, _CMP_GE_OQ), kMiddleInFirstSlab);
    store(&SlabRays::slope, _mm512_cvttpd_epu32(units(slope)));
    store(&SlabRays::fraction, _mm512_cvttpd_epu32(_mm512_add_pd(fraction, tolerance_)));
  }

  /// Computes, for faces across z, the slab in which each ray crosses the first face, the number of slabs from one face
  /// to the next, and the ray's position along b at each face.
  void set_up_minor() {
    const __m512d one = _mm512_set1_pd(1), two = _mm512_set1_pd(2), zero = _mm512_setzero_pd();
    suited_ &= _mm512_cmp_pd_mask(_mm512_div_pd(da_, dz_), _mm512_set1_pd(kSteepest), _CMP_LT_OQ);
    const __mmask8 moves = _mm512_cmp_pd_mask(db_, _mm512_set1_pd(kNever), _CMP_LT_OQ);
    const __mmask8 climbs = _mm512_cmp_pd_mask(dz_, _mm512_set1_pd(kNever), _CMP_LT_OQ);
    const __m512d slab =
        _mm512_mask_add_pd(_mm512_set1_pd(2 * kMostSlabs), climbs, _mm512_div_pd(_mm512_sub_pd(tz_, ta_), da_), one);
    const __mmask8 any = _mm512_cmp_pd_mask(slab, _mm512_add_pd(na_, one), _CMP_LT_OQ);
    const __m512d fraction = certain_fraction(slab, any);
    const __m512d between = _mm512_min_pd(_mm512_maskz_div_pd(any, dz_, da_), _mm512_set1_pd(1 << 20));
    const __m512d between_down = floor(between);
    const __m256i never = _mm256_set1_epi32(static_cast<int>(kNoSlab));
    store(&SlabRays::minor_slab, _mm256_mask_mov_epi32(never, any, _mm512_cvttpd_epu32(floor(slab))));
    store(&SlabRays::minor_fraction,
          _mm256_mask_mov_epi32(never, any, _mm512_cvttpd_epu32(_mm512_add_pd(fraction, tolerance_))));
    store(&SlabRays::minor_slabs, _mm256_maskz_mov_epi32(any, _mm512_cvttpd_epu32(between_down)));
    store(&SlabRays::minor_slabs_fraction,
          _mm256_maskz_mov_epi32(any, _mm512_cvttpd_epu32(units(_mm512_sub_pd(between, between_down)))));
    const __m512d middle = _mm512_mask_add_pd(_mm512_set1_pd(0.5), static_cast<__mmask8>(moves & any),
                                              _mm512_maskz_div_pd(moves, _mm512_sub_pd(tz_, tb_), db_), one);
    certain_fraction(middle, any);
    const __m512d middles = _mm512_maskz_div_pd(static_cast<__mmask8>(moves & any), dz_, db_);
    const auto modulo_two = [&](__m512d x, __m512d plus) {  // in units of 2^-32 of two voxels, so that it wraps around
      const __m512d rest = _mm512_sub_pd(x, _mm512_mul_pd(two, floor(_mm512_div_pd(x, two))));
      return _mm512_cvttpd_epu32(_mm512_add_pd(_mm512_mul_pd(rest, _mm512_set1_pd(kUnits / 2)), plus));
    };
    const __m512d origin_b =
        _mm512_mask_mov_pd(_mm512_set1_pd(in_.origin_key[1] & 1), along_y_, _mm512_set1_pd(in_.origin_key[0] & 1));
    const __m512d clipped = _mm512_min_pd(_mm512_max_pd(middle, zero), _mm512_set1_pd(4 * kMostSlabs));
    store(&SlabRays::minor_middle, modulo_two(_mm512_add_pd(clipped, origin_b), tolerance_));
    store(&SlabRays::minor_middles, modulo_two(_mm512_min_pd(middles, _mm512_set1_pd(1 << 20)), zero));
  }

  const SlabInput& in_;
  const std::size_t first_;
  const __mmask8 lanes_;
  __mmask8 along_y_, suited_;
  __m512d ta_, tb_, tz_, da_, db_, dz_, na_, nb_, nz_, tolerance_;
  __m256i flags_ = _mm256_setzero_si256();
};

void set_up_slabs(const SlabInput& in) {
  for (std::size_t i = 0; i < in.count; i += 8) EightSlabSetups(in, i).set_up();
}

}  // namespace
}  // namespace uwsim::bricks
