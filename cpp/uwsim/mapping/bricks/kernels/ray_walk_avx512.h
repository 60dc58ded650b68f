#pragma once

#include "uwsim/mapping/bricks/kernels/ray_walk.h"

/// The counterpart of ray_walk.h for 32 rays at a time. Only the files named scan_kernels_*avx512.cpp may include this
/// file, after <immintrin.h>.
namespace uwsim::bricks {
namespace {

inline __m512i all_lanes(std::uint64_t value) { return _mm512_set1_epi32(static_cast<int>(value)); }

/// Adds one to the bits of `axis` in each address, as if they were adjacent.
inline __m512i add_one(__m512i address, __m512i axis) {
  const __m512i others_set = _mm512_ternarylogic_epi32(address, axis, axis, 0xf3);  // address | ~axis
  const __m512i sum = _mm512_sub_epi32(others_set, _mm512_set1_epi32(-1));
  return _mm512_ternarylogic_epi32(axis, sum, address, 0xca);  // axis ? sum : address, bit by bit
}

/// A buffer of marks to be written to the table: each mark is the index of a half word (4 x 4 x 2 voxels) and its bits.
/// The caller keeps the number of marks, so that this number stays in a register.
class MarkBuffer {
 public:
  using HalfWord __attribute__((may_alias)) = std::uint32_t;
  static constexpr std::size_t kCapacity = 4096;

  explicit MarkBuffer(const WalkInput& walk)
      : table_(reinterpret_cast<HalfWord*>(walk.table)), touched_(walk.touched) {}

  /// Appends those of the lanes' marks that `which` selects, after the first `marks` marks; returns the new number of
  /// marks.
  std::size_t append(std::size_t marks, __mmask16 which, __m512i half, __m512i mask) {
    _mm512_storeu_si512(halves_ + marks, _mm512_maskz_compress_epi32(which, half));
    _mm512_storeu_si512(masks_ + marks, _mm512_maskz_compress_epi32(which, mask));
    return marks + static_cast<std::size_t>(__builtin_popcount(which));
  }

  /// Writes the first `marks` marks. Successive marks often fall into the same word, where each would have to wait for
  /// the previous one to be written. The buffer is therefore written from eight positions in turn.
  void write(std::size_t marks) {
    constexpr std::size_t kPlaces = 8;
    const std::size_t stride = marks / kPlaces;
    for (std::size_t i = 0; i < stride; ++i) {
      for (std::size_t place = 0; place < kPlaces; ++place) write_one(place * stride + i);
    }
    for (std::size_t i = kPlaces * stride; i < marks; ++i) write_one(i);
  }

 private:
  void write_one(std::size_t i) {
    table_[halves_[i]] |= masks_[i];
    touched_[halves_[i] >> 4] = 1;
  }

  HalfWord* table_;
  std::uint8_t* touched_;
  alignas(64) std::uint32_t halves_[kCapacity];
  alignas(64) std::uint32_t masks_[kCapacity];
};

/// The next face crossings of eight rays, in double precision.
struct EightCrossings {
  __m512d tx, ty, tz, dx, dy, dz, length;

  void start(const Rays& rays, const std::uint32_t* which) {
    const __m256i index = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(which));
    const auto gather = [&](const double* column) { return _mm512_i32gather_pd(index, column, 8); };
    tx = gather(rays.next[0]);
    ty = gather(rays.next[1]);
    tz = gather(rays.next[2]);
    dx = gather(rays.stride[0]);
    dy = gather(rays.stride[1]);
    dz = gather(rays.stride[2]);
    length = gather(rays.length);
  }

  struct Axes {
    __mmask8 x, y;
  };

  /// Lets each ray cross its nearest face; returns which rays crossed a face across x and across y.
  Axes step() {
    const __mmask8 not_z = _mm512_cmp_pd_mask(_mm512_min_pd(tx, ty), tz, _CMP_LT_OQ);
    const __mmask8 along_x = _mm512_mask_cmp_pd_mask(not_z, tx, ty, _CMP_LT_OQ);
    const __mmask8 along_y = _kandn_mask8(along_x, not_z);
    tx = _mm512_mask_add_pd(tx, along_x, tx, dx);
    ty = _mm512_mask_add_pd(ty, along_y, ty, dy);
    tz = _mm512_mask_add_pd(tz, _knot_mask8(not_z), tz, dz);
    return {along_x, along_y};
  }

  /// A mask of the rays that cross their next face beyond their length.
  __mmask8 past() const { return _mm512_cmp_pd_mask(_mm512_min_pd(_mm512_min_pd(tx, ty), tz), length, _CMP_GT_OQ); }
};

/// Sixteen rays. Each ray collects the bits of the half word that it is in, and appends them to the buffer when it
/// leaves the half word.
struct SixteenRays {
  EightCrossings low, high;
  __m512i mirror, end, address;
  __m512i half, mask;  ///< the half word that a ray is in, and the bits it has marked there
  __mmask16 walking;

  void start(const WalkInput& in, const std::uint32_t* rays) {
    low.start(*in.rays, rays);
    high.start(*in.rays, rays + 8);
    alignas(64) std::uint32_t mirrors[16], ends[16];
    for (int lane = 0; lane < 16; ++lane) {
      mirrors[lane] = static_cast<std::uint32_t>(mirror_of(in, in.rays->negative[rays[lane]]));
      ends[lane] = static_cast<std::uint32_t>(in.end_address[rays[lane]]);
    }
    mirror = _mm512_load_si512(mirrors);
    end = _mm512_load_si512(ends);
    const __m512i origin = all_lanes(in.origin_address);
    address = _mm512_xor_si512(origin, mirror);
    half = _mm512_srli_epi32(origin, 5);
    mask = _mm512_rolv_epi32(_mm512_set1_epi32(1), origin);
    walking = 0xffff;
  }

  void step(__m512i axis_x, __m512i axis_y, __m512i axis_z) {
    const EightCrossings::Axes below = low.step(), above = high.step();
    const __mmask16 along_x = _mm512_kunpackb(above.x, below.x), along_y = _mm512_kunpackb(above.y, below.y);
    const __m512i axis = _mm512_mask_mov_epi32(_mm512_mask_mov_epi32(axis_z, along_x, axis_x), along_y, axis_y);
    address = add_one(address, axis);
  }

  /// Marks the voxel that each ray is in now.
  std::size_t mark(MarkBuffer& buffer, std::size_t count) {
    const __m512i real = _mm512_xor_si512(address, mirror);
    const __m512i next = _mm512_srli_epi32(real, 5);
    const __mmask16 stays = _mm512_cmpeq_epi32_mask(next, half);
    count = append(buffer, count, _knot_mask16(stays));
    const __m512i bit = _mm512_rolv_epi32(_mm512_set1_epi32(1), real);
    mask = _mm512_mask_or_epi32(bit, stays, mask, bit);
    half = next;
    return count;
  }

  /// Marks the voxels of the rays that are still walking.
  std::size_t mark_walking(MarkBuffer& buffer, std::size_t count) {
    const __m512i real = _mm512_xor_si512(address, mirror);
    const __m512i next = _mm512_srli_epi32(real, 5);
    const __mmask16 left = _mm512_mask_cmpneq_epi32_mask(walking, next, half);
    count = append(buffer, count, left);
    const __m512i bit = _mm512_rolv_epi32(_mm512_set1_epi32(1), real);
    mask = _mm512_maskz_mov_epi32(_knot_mask16(left), mask);
    mask = _mm512_mask_or_epi32(mask, walking, mask, bit);
    half = _mm512_mask_mov_epi32(half, walking, next);
    return count;
  }

  /// Stops the rays that have reached their end; returns whether any is still walking.
  bool stop_ended() {
    const __mmask16 past = _mm512_kunpackb(high.past(), low.past());
    walking &= static_cast<__mmask16>(~(past | _mm512_cmpeq_epi32_mask(address, end)));
    return walking != 0;
  }

  std::size_t append(MarkBuffer& buffer, std::size_t count, __mmask16 which) const {
    return buffer.append(count, which, half, mask);
  }
};

std::size_t walk_to_the_end(SixteenRays rays, __m512i axis_x, __m512i axis_y, __m512i axis_z, MarkBuffer& buffer,
                            std::size_t count) {
  for (;;) {
    rays.step(axis_x, axis_y, axis_z);
    if (!rays.stop_ended()) break;
    count = rays.mark_walking(buffer, count);
    if (count > MarkBuffer::kCapacity / 2) {
      buffer.write(count);
      count = 0;
    }
  }
  return rays.append(buffer, count, 0xffff);
}

/// Walks two groups of sixteen rays: while one group waits for the result of a comparison, the other proceeds.
void walk_thirty_two(const WalkInput& in, const std::uint32_t* rays, MarkBuffer& buffer) {
  const __m512i axis_x = all_lanes(in.axis_mask[0]), axis_y = all_lanes(in.axis_mask[1]),
                axis_z = all_lanes(in.axis_mask[2]);
  SixteenRays a, b;
  a.start(in, rays);
  b.start(in, rays + 16);
  std::uint32_t steps = ~0u;
  for (int lane = 0; lane < 32; ++lane) {
    const std::uint32_t mine = untested_steps(in.rays->steps[rays[lane]]);
    steps = mine < steps ? mine : steps;
  }
  std::size_t count = 0;
  for (--steps; steps > 0;) {
    const std::uint32_t some = steps < 64 ? steps : 64;  // their marks fill at most half the buffer
    steps -= some;
    for (std::uint32_t k = 0; k < some; ++k) {
      a.step(axis_x, axis_y, axis_z);
      b.step(axis_x, axis_y, axis_z);
      count = a.mark(buffer, count);
      count = b.mark(buffer, count);
    }
    if (count > MarkBuffer::kCapacity / 4) {
      buffer.write(count);
      count = 0;
    }
  }
  count = walk_to_the_end(a, axis_x, axis_y, axis_z, buffer, count);
  count = walk_to_the_end(b, axis_x, axis_y, axis_z, buffer, count);
  buffer.write(count);
}

void walk_thirty_two_at_a_time(const WalkInput& in) {
  if (!in.table) return walk_one_by_one(in);
  MarkBuffer buffer(in);
  for (std::size_t i = 0; i < in.count; i += 32) walk_thirty_two(in, in.order + i, buffer);
}

}  // namespace
}  // namespace uwsim::bricks
