#pragma once

#include "uwsim/mapping/bricks/kernels/ray_walk.h"

/// The counterpart of ray_walk.h for eight rays at a time. Only scan_kernels_avx2.cpp may include this file, after
/// <immintrin.h>.
namespace uwsim::bricks {
namespace {

/// Combines two masks of four quadwords into one mask of eight dwords, by selecting the even dwords in order.
__m256i narrowed(__m256d low, __m256d high) {
  const __m256 mixed = _mm256_shuffle_ps(_mm256_castpd_ps(low), _mm256_castpd_ps(high), 0x88);
  return _mm256_permute4x64_epi64(_mm256_castps_si256(mixed), 0xd8);
}

/// The next face crossings of four rays, in double precision.
struct FourCrossings {
  __m256d tx, ty, tz, dx, dy, dz;

  static __m256d gather(const double* column, const std::uint32_t* rays) {
    return _mm256_setr_pd(column[rays[0]], column[rays[1]], column[rays[2]], column[rays[3]]);
  }

  FourCrossings(const Rays& rays, const std::uint32_t* which)
      : tx(gather(rays.next[0], which)),
        ty(gather(rays.next[1], which)),
        tz(gather(rays.next[2], which)),
        dx(gather(rays.stride[0], which)),
        dy(gather(rays.stride[1], which)),
        dz(gather(rays.stride[2], which)) {}

  struct Axes {
    __m256d x, y;
  };

  /// Lets each ray cross its nearest face; returns which rays crossed a face across x and across y. For the other axes,
  /// zero is added, which changes nothing.
  Axes step() {
    const __m256d not_z = _mm256_cmp_pd(_mm256_min_pd(tx, ty), tz, _CMP_LT_OQ);
    const __m256d first = _mm256_cmp_pd(tx, ty, _CMP_LT_OQ);
    const __m256d along_x = _mm256_and_pd(first, not_z), along_y = _mm256_andnot_pd(first, not_z);
    tx = _mm256_add_pd(tx, _mm256_and_pd(along_x, dx));
    ty = _mm256_add_pd(ty, _mm256_and_pd(along_y, dy));
    tz = _mm256_add_pd(tz, _mm256_andnot_pd(not_z, dz));
    return {along_x, along_y};
  }

  /// A mask of the rays that cross their next face beyond their length.
  __m256d past(__m256d length) const {
    return _mm256_cmp_pd(_mm256_min_pd(_mm256_min_pd(tx, ty), tz), length, _CMP_GT_OQ);
  }
};

class EightRays {
 public:
  EightRays(const WalkInput& in, const std::uint32_t* rays)
      : in_(in),
        low_(*in.rays, rays),
        high_(*in.rays, rays + 4),
        axis_x_(_mm256_set1_epi32(static_cast<int>(in.axis_mask[0]))),
        axis_y_(_mm256_set1_epi32(static_cast<int>(in.axis_mask[1]))),
        axis_z_(_mm256_set1_epi32(static_cast<int>(in.axis_mask[2]))) {
    alignas(32) std::uint32_t mirror[8], end[8];
    alignas(32) double length[8];
    for (int lane = 0; lane < 8; ++lane) {
      const std::uint32_t ray = rays[lane];
      mirror[lane] = static_cast<std::uint32_t>(mirror_of(in, in.rays->negative[ray]));
      end[lane] = static_cast<std::uint32_t>(in.end_address[ray]);
      length[lane] = in.rays->length[ray];
      const std::uint32_t steps = untested_steps(in.rays->steps[ray]);
      untested_ = steps < untested_ ? steps : untested_;
    }
    mirror_ = _mm256_load_si256(reinterpret_cast<const __m256i*>(mirror));
    end_ = _mm256_load_si256(reinterpret_cast<const __m256i*>(end));
    low_length_ = _mm256_load_pd(length);
    high_length_ = _mm256_load_pd(length + 4);
    address_ = _mm256_xor_si256(_mm256_set1_epi32(static_cast<int>(in.origin_address)), mirror_);
  }

  void walk() {
    mark(0xff);
    for (std::uint32_t k = 1; k < untested_; ++k) {
      step();
      mark(0xff);
    }
    for (unsigned walking = 0xff;;) {
      step();
      const __m256i past = narrowed(low_.past(low_length_), high_.past(high_length_));
      const __m256i done = _mm256_or_si256(past, _mm256_cmpeq_epi32(address_, end_));
      walking &= ~static_cast<unsigned>(_mm256_movemask_ps(_mm256_castsi256_ps(done)));
      if (!walking) break;
      mark(walking);
    }
  }

 private:
  void step() {
    const FourCrossings::Axes low = low_.step(), high = high_.step();
    const __m256 along_x = _mm256_castsi256_ps(narrowed(low.x, high.x));
    const __m256 along_y = _mm256_castsi256_ps(narrowed(low.y, high.y));
    __m256 axis = _mm256_blendv_ps(_mm256_castsi256_ps(axis_z_), _mm256_castsi256_ps(axis_x_), along_x);
    axis = _mm256_blendv_ps(axis, _mm256_castsi256_ps(axis_y_), along_y);
    const __m256i mask = _mm256_castps_si256(axis), ones = _mm256_set1_epi32(-1);
    const __m256i others = _mm256_andnot_si256(mask, address_);
    const __m256i others_full = _mm256_or_si256(address_, _mm256_xor_si256(mask, ones));
    address_ = _mm256_or_si256(others, _mm256_and_si256(mask, _mm256_sub_epi32(others_full, ones)));
  }

  void mark(unsigned walking) {
    alignas(32) std::uint32_t real[8];
    _mm256_store_si256(reinterpret_cast<__m256i*>(real), _mm256_xor_si256(address_, mirror_));
    if (walking == 0xff) {
      for (int lane = 0; lane < 8; ++lane) mark_voxel(real[lane]);
      return;
    }
    for (; walking != 0; walking &= walking - 1) mark_voxel(real[__builtin_ctz(walking)]);
  }

  void mark_voxel(std::uint32_t address) {
    in_.table[address >> 6] |= std::uint64_t{1} << (address & 63);
    in_.touched[address >> 9] = 1;
  }

  const WalkInput& in_;
  FourCrossings low_, high_;
  const __m256i axis_x_, axis_y_, axis_z_;
  __m256i mirror_, end_, address_;
  __m256d low_length_, high_length_;
  std::uint32_t untested_ = ~0u;  ///< untested_steps() of the ray for which it is smallest
};

void walk_eight_at_a_time(const WalkInput& in) {
  if (!in.table) return walk_one_by_one(in);
  for (std::size_t i = 0; i < in.count; i += 8) EightRays(in, in.order + i).walk();
}

}  // namespace
}  // namespace uwsim::bricks
