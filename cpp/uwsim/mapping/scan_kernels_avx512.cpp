#include <immintrin.h>

#include "uwsim/mapping/scan_pending_avx512.h"
#include "uwsim/mapping/scan_start_avx512.h"

namespace uwsim::bricks {
namespace {

struct Avx512 {
  static std::uint64_t touched(const std::uint8_t* bytes) {
    const __m512i all = _mm512_loadu_si512(bytes);
    return _mm512_test_epi8_mask(all, all);
  }

  static void wipe(std::uint8_t* bytes) { _mm512_storeu_si512(bytes, _mm512_setzero_si512()); }

  static std::uint8_t compress(std::uint64_t* words, std::uint64_t* out) {
    const __m512i all = _mm512_load_si512(words);
    const __mmask8 which = _mm512_test_epi64_mask(all, all);
    _mm512_storeu_si512(out, _mm512_maskz_compress_epi64(which, all));
    _mm512_store_si512(words, _mm512_setzero_si512());
    return which;
  }

  static std::uint64_t miss(float* block, std::uint64_t todo, const SensorModel& model) {
    const __m512 add = _mm512_set1_ps(model.miss), lowest = _mm512_set1_ps(model.lowest),
                 highest = _mm512_set1_ps(model.highest);
    std::uint64_t low = 0;
    for (int i = 0; i < 4; ++i) {
      const __mmask16 lanes = static_cast<__mmask16>(todo >> (16 * i));
      const __m512 old = _mm512_load_ps(block + 16 * i);
      const __m512 next = _mm512_min_ps(_mm512_max_ps(_mm512_add_ps(old, add), lowest), highest);
      _mm512_mask_store_ps(block + 16 * i, lanes, next);
      low |= static_cast<std::uint64_t>(_mm512_mask_cmp_ps_mask(lanes, next, lowest, _CMP_LE_OQ)) << (16 * i);
    }
    return low;
  }

  static void fill(float* block, std::uint64_t bits, float value) {
    const __m512 values = _mm512_set1_ps(value);
    for (int i = 0; i < 4; ++i) {
      _mm512_store_ps(block + 16 * i, _mm512_maskz_mov_ps(static_cast<__mmask16>(bits >> (16 * i)), values));
    }
  }

  static bool all_equal(const float* block, std::uint64_t bits, float value) {
    const __m512 wanted = _mm512_set1_ps(value);
    for (int i = 0; i < 4; ++i) {
      const __mmask16 lanes = static_cast<__mmask16>(bits >> (16 * i));
      if (_mm512_mask_cmp_ps_mask(lanes, _mm512_load_ps(block + 16 * i), wanted, _CMP_NEQ_UQ)) return false;
    }
    return true;
  }
};

/// A step of eight rays: the axis whose face comes first, z before y before x where they tie, as in OctoMap.
struct Eight {
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

  Axes step() {
    const __mmask8 not_z = _mm512_cmp_pd_mask(_mm512_min_pd(tx, ty), tz, _CMP_LT_OQ);
    const __mmask8 along_x = _mm512_mask_cmp_pd_mask(not_z, tx, ty, _CMP_LT_OQ);
    const __mmask8 along_y = _kandn_mask8(along_x, not_z);
    tx = _mm512_mask_add_pd(tx, along_x, tx, dx);
    ty = _mm512_mask_add_pd(ty, along_y, ty, dy);
    tz = _mm512_mask_add_pd(tz, _knot_mask8(not_z), tz, dz);
    return {along_x, along_y};
  }

  __mmask8 ends() const { return _mm512_cmp_pd_mask(_mm512_min_pd(_mm512_min_pd(tx, ty), tz), length, _CMP_GT_OQ); }
};

/// Sixteen rays side by side. What is pending is counted by the caller, in a register.
struct Sixteen {
  Eight low, high;
  __m512i mirror, end, address, half, mask;
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
    const __m512i origin = _mm512_set1_epi32(static_cast<int>(in.origin_address));
    address = _mm512_xor_si512(origin, mirror);
    half = _mm512_srli_epi32(origin, 5);
    mask = _mm512_rolv_epi32(_mm512_set1_epi32(1), origin);
    walking = 0xffff;
  }

  void step(__m512i axis_x, __m512i axis_y, __m512i axis_z) {
    const Eight::Axes below = low.step(), above = high.step();
    const __mmask16 along_x = _mm512_kunpackb(above.x, below.x), along_y = _mm512_kunpackb(above.y, below.y);
    const __m512i axis = _mm512_mask_mov_epi32(_mm512_mask_mov_epi32(axis_z, along_x, axis_x), along_y, axis_y);
    const __m512i others_full = _mm512_ternarylogic_epi32(address, axis, axis, 0xf3);  // address | ~axis
    const __m512i stepped = _mm512_sub_epi32(others_full, _mm512_set1_epi32(-1));
    address = _mm512_ternarylogic_epi32(axis, stepped, address, 0xca);  // axis ? stepped : address
  }

  /// Marks the voxels where all rays are now.
  std::size_t mark(Pending& pending, std::size_t count) {
    const __m512i real = _mm512_xor_si512(address, mirror);
    const __m512i next = _mm512_srli_epi32(real, 5);
    const __mmask16 stays = _mm512_cmpeq_epi32_mask(next, half);
    count = leave(pending, count, _knot_mask16(stays));
    const __m512i bit = _mm512_rolv_epi32(_mm512_set1_epi32(1), real);
    mask = _mm512_mask_or_epi32(bit, stays, mask, bit);
    half = next;
    return count;
  }

  /// The same where rays are still walking.
  std::size_t mark_walking(Pending& pending, std::size_t count) {
    const __m512i real = _mm512_xor_si512(address, mirror);
    const __m512i next = _mm512_srli_epi32(real, 5);
    const __mmask16 left = _mm512_mask_cmpneq_epi32_mask(walking, next, half);
    count = leave(pending, count, left);
    const __m512i bit = _mm512_rolv_epi32(_mm512_set1_epi32(1), real);
    mask = _mm512_maskz_mov_epi32(_knot_mask16(left), mask);
    mask = _mm512_mask_or_epi32(mask, walking, mask, bit);
    half = _mm512_mask_mov_epi32(half, walking, next);
    return count;
  }

  /// False when all have come to their end.
  bool go_on() {
    const __mmask16 past = _mm512_kunpackb(high.ends(), low.ends());
    walking &= static_cast<__mmask16>(~(past | _mm512_cmpeq_epi32_mask(address, end)));
    return walking != 0;
  }

  std::size_t leave(Pending& pending, std::size_t count, __mmask16 which) const {
    _mm512_storeu_si512(pending.halves + count, _mm512_maskz_compress_epi32(which, half));
    _mm512_storeu_si512(pending.masks + count, _mm512_maskz_compress_epi32(which, mask));
    return count + static_cast<std::size_t>(__builtin_popcount(which));
  }
};

std::size_t walk_to_the_end(Sixteen rays, __m512i axis_x, __m512i axis_y, __m512i axis_z, Pending& pending,
                            std::size_t count) {
  for (;;) {
    rays.step(axis_x, axis_y, axis_z);
    if (!rays.go_on()) break;
    count = rays.mark_walking(pending, count);
    if (count > Pending::kRoom / 2) {
      pending.put(count);
      count = 0;
    }
  }
  return rays.leave(pending, count, 0xffff);
}

/// Two times sixteen rays: while the ones wait for a comparison, the others go on.
void walk_side_by_side(const WalkInput& in, const std::uint32_t* rays, Pending& pending) {
  const __m512i axis_x = _mm512_set1_epi32(static_cast<int>(in.axis_mask[0])),
                axis_y = _mm512_set1_epi32(static_cast<int>(in.axis_mask[1])),
                axis_z = _mm512_set1_epi32(static_cast<int>(in.axis_mask[2]));
  Sixteen a, b;
  a.start(in, rays);
  b.start(in, rays + 16);
  std::uint32_t steps = ~0u;
  for (int lane = 0; lane < 32; ++lane) {
    const std::uint32_t mine = untested(in.rays->steps[rays[lane]]);
    steps = mine < steps ? mine : steps;
  }
  std::size_t count = 0;
  for (--steps; steps > 0;) {
    const std::uint32_t some = steps < 64 ? steps : 64;  // their marks fit half the room
    steps -= some;
    for (std::uint32_t k = 0; k < some; ++k) {
      a.step(axis_x, axis_y, axis_z);
      b.step(axis_x, axis_y, axis_z);
      count = a.mark(pending, count);
      count = b.mark(pending, count);
    }
    if (count > Pending::kRoom / 4) {
      pending.put(count);
      count = 0;
    }
  }
  count = walk_to_the_end(a, axis_x, axis_y, axis_z, pending, count);
  count = walk_to_the_end(b, axis_x, axis_y, axis_z, pending, count);
  pending.put(count);
}

void walk(const WalkInput& in) {
  if (!in.table) {
    for (std::size_t i = 0; i < in.count; ++i) walk_one(in, in.order[i]);
    return;
  }
  Pending pending;
  pending.table = reinterpret_cast<Pending::HalfWord*>(in.table);
  pending.touched = in.touched;
  for (std::size_t i = 0; i < in.count; i += 32) walk_side_by_side(in, in.order + i, pending);
}

}  // namespace

const Kernels kAvx512Kernels{start_eights, walk, collect_chunk<Avx512>, update_bricks<Avx512>, &kAvx512SlabKernels};

}  // namespace uwsim::bricks
