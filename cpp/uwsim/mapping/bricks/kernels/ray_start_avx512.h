#pragma once

#include "uwsim/mapping/bricks/kernels/ray_start.h"

/// The counterpart of ray_start.h for eight rays at a time, with the same operations in the same order. Only the files
/// named scan_kernels_*avx512.cpp may include this file, after <immintrin.h>.
namespace uwsim::bricks {
namespace {

class EightStarts {
 public:
  EightStarts(const ScanInput& scan, const Rays& rays) : scan_(scan), rays_(rays) {
    const double resolution = scan.resolution_m;
    const double half = static_cast<double>(static_cast<float>(resolution * 0.5));
    for (int axis = 0; axis < 3; ++axis) {
      const double origin = static_cast<double>(scan.origin_m[axis]);
      const int key = static_cast<int>(__builtin_floor(1.0 / resolution * origin));
      const double middle = (static_cast<double>(key) + 0.5) * resolution;
      origin_key_[axis] = key + 32768;
      border_down_[axis] = middle - half - origin;
      border_up_[axis] = middle + half - origin;
    }
  }

  void start(std::size_t first) {
    first_ = first;
    lanes_ = static_cast<__mmask8>(scan_.count - first < 8 ? (1u << (scan_.count - first)) - 1 : 255);
    __m256 delta[3], end[3];
    const __mmask8 finite = load(delta, end);
    const __mmask8 truncated = find_ends(delta, end);
    __m256i steps = _mm256_setzero_si256();
    __m128i negative = _mm_setzero_si128();
    for (int axis = 0; axis < 3; ++axis) {
      const __m256i key = start_axis(axis, finite, delta[axis], end[axis]);
      steps = _mm256_add_epi32(steps, _mm256_abs_epi32(_mm256_sub_epi32(key, _mm256_set1_epi32(origin_key_[axis]))));
      const __mmask8 down = _mm256_cmp_ps_mask(delta[axis], _mm256_setzero_ps(), _CMP_LT_OQ);
      negative = _mm_mask_add_epi8(negative, down, negative, _mm_set1_epi8(static_cast<char>(1 << axis)));
    }
    _mm256_mask_storeu_epi32(rays_.steps + first, lanes_, steps);
    _mm_mask_storeu_epi8(rays_.negative + first, lanes_, negative);
    const __m128i kind = _mm_mask_mov_epi8(_mm_set1_epi8(kHit), truncated, _mm_set1_epi8(kTruncated));
    _mm_mask_storeu_epi8(rays_.kind + first, lanes_, _mm_maskz_mov_epi8(finite, kind));
  }

 private:
  static __m256 all(float x) { return _mm256_set1_ps(x); }
  static __m256 narrowed(__m512d x) { return _mm512_cvtpd_ps(x); }

  static __m512d length(const __m256 (&v)[3], __m256& square) {
    square =
        _mm256_add_ps(_mm256_add_ps(_mm256_mul_ps(v[0], v[0]), _mm256_mul_ps(v[1], v[1])), _mm256_mul_ps(v[2], v[2]));
    return _mm512_sqrt_pd(_mm512_cvtps_pd(square));
  }

  /// Computes points in the tree's frame, and the vectors from the origin to them. Returns a mask of the finite points.
  __mmask8 load(__m256 (&delta)[3], __m256 (&point)[3]) const {
    const __m256i rows = _mm256_setr_epi32(0, 3, 6, 9, 12, 15, 18, 21);
    __mmask8 finite = lanes_;
    for (int axis = 0; axis < 3; ++axis) {
      const float* const column = scan_.points_world_m + 3 * first_ + axis;
      const __m256 world = _mm256_mmask_i32gather_ps(_mm256_setzero_ps(), lanes_, rows, column, 4);
      const __m256 size = _mm256_andnot_ps(all(-0.0f), world);
      finite &= _mm256_cmp_ps_mask(size, all(kGreatestFloat), _CMP_LE_OQ);
      point[axis] = narrowed(_mm512_sub_pd(_mm512_cvtps_pd(world), _mm512_set1_pd(scan_.tree_origin_world_m[axis])));
      delta[axis] = _mm256_sub_ps(point[axis], all(scan_.origin_m[axis]));
    }
    return finite;
  }

  /// Does the work of end_of_ray(): replaces the points in `end` by the ends of the rays and the vectors in `delta` by
  /// directions. Returns a mask of the truncated rays.
  __mmask8 find_ends(__m256 (&delta)[3], __m256 (&end)[3]) const {
    __m256 square, unused;
    const __m512d distance = length(delta, square);
    const __mmask8 truncated = static_cast<__mmask8>(
        scan_.max_range_m < 0 ? 0 : ~_mm512_cmp_pd_mask(distance, _mm512_set1_pd(scan_.max_range_m), _CMP_LE_OQ));
    __m256 length_m = narrowed(distance);
    const __mmask8 at_origin = _mm256_cmp_ps_mask(square, _mm256_setzero_ps(), _CMP_EQ_OQ);
    __m256 truncated_delta[3];
    for (int axis = 0; axis < 3; ++axis) {
      const __m256 origin = all(scan_.origin_m[axis]);
      const __m256 reach = all(static_cast<float>(scan_.max_range_m));
      const __m256 truncated_end = _mm256_add_ps(origin, _mm256_mul_ps(_mm256_div_ps(delta[axis], length_m), reach));
      truncated_delta[axis] = _mm256_sub_ps(truncated_end, origin);
      end[axis] = _mm256_mask_mov_ps(_mm256_mask_mov_ps(end[axis], at_origin, origin), truncated, truncated_end);
    }
    length_m = _mm256_mask_mov_ps(length_m, truncated, narrowed(length(truncated_delta, unused)));
    for (int axis = 0; axis < 3; ++axis) {
      delta[axis] = _mm256_div_ps(_mm256_mask_mov_ps(delta[axis], truncated, truncated_delta[axis]), length_m);
    }
    _mm512_mask_storeu_pd(rays_.length + first_, lanes_, _mm512_cvtps_pd(length_m));
    return truncated;
  }

  /// Returns the key of the ray's end along the axis.
  __m256i start_axis(int axis, __mmask8 finite, __m256 direction_m, __m256 end) const {
    const __m512d scaled = _mm512_mul_pd(_mm512_set1_pd(1.0 / scan_.resolution_m), _mm512_cvtps_pd(end));
    const __m512d floor = _mm512_roundscale_pd(scaled, _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC);
    const __m256i origin = _mm256_set1_epi32(origin_key_[axis]);
    const __m256i key = _mm256_mask_add_epi32(origin, finite, _mm512_cvttpd_epi32(floor), _mm256_set1_epi32(32768));
    _mm_mask_storeu_epi16(rays_.end_key[axis] + first_, lanes_, _mm256_cvtepi32_epi16(key));
    const __m512d direction = _mm512_cvtps_pd(direction_m), zero = _mm512_setzero_pd();
    const __m512d never = _mm512_set1_pd(kNeverCrosses);
    const __mmask8 down = _mm512_cmp_pd_mask(direction, zero, _CMP_LT_OQ);
    const __mmask8 moves = static_cast<__mmask8>(down | _mm512_cmp_pd_mask(direction, zero, _CMP_GT_OQ));
    const __m512d border =
        _mm512_mask_mov_pd(_mm512_set1_pd(border_up_[axis]), down, _mm512_set1_pd(border_down_[axis]));
    _mm512_mask_storeu_pd(rays_.next[axis] + first_, lanes_, _mm512_mask_div_pd(never, moves, border, direction));
    const __m512d resolution = _mm512_set1_pd(scan_.resolution_m);
    _mm512_mask_storeu_pd(rays_.stride[axis] + first_, lanes_,
                          _mm512_mask_div_pd(never, moves, resolution, _mm512_abs_pd(direction)));
    return key;
  }

  const ScanInput& scan_;
  const Rays& rays_;
  std::size_t first_ = 0;
  __mmask8 lanes_ = 0;
  int origin_key_[3];
  double border_down_[3], border_up_[3];  ///< faces of the origin's voxel, relative to the origin [m]
};

inline void start_eight_at_a_time(const ScanInput& scan, const Rays& rays) {
  EightStarts starts(scan, rays);
  for (std::size_t i = 0; i < scan.count; i += 8) starts.start(i);
}

}  // namespace
}  // namespace uwsim::bricks
