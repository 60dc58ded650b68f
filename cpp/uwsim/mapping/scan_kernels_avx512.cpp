#include <immintrin.h>

#include "uwsim/mapping/scan_kernels_common.h"

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
  __m512d tx, ty, tz, dx, dy, dz;

  static __m512d gather(const double* column, __m256i rays) { return _mm512_i32gather_pd(rays, column, 8); }

  Eight(const Rays& rays, __m256i which)
      : tx(gather(rays.next[0], which)),
        ty(gather(rays.next[1], which)),
        tz(gather(rays.next[2], which)),
        dx(gather(rays.stride[0], which)),
        dy(gather(rays.stride[1], which)),
        dz(gather(rays.stride[2], which)) {}

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

  __mmask8 ends(__m512d length) const {
    return _mm512_cmp_pd_mask(_mm512_min_pd(_mm512_min_pd(tx, ty), tz), length, _CMP_GT_OQ);
  }
};

/// Words that rays have left, with the bits they set there, until they are put down.
struct Pending {
  static constexpr std::size_t kRoom = 2048;

  explicit Pending(const WalkInput& in) : table(in.table), touched(in.touched) {}

  void add(__mmask16 which, __m512i word, __m512i low_mask, __m512i high_mask) {
    const __mmask8 low = static_cast<__mmask8>(which), high = static_cast<__mmask8>(which >> 8);
    _mm512_storeu_si512(words + count, _mm512_maskz_compress_epi32(which, word));
    _mm512_storeu_si512(masks + count, _mm512_maskz_compress_epi64(low, low_mask));
    _mm512_storeu_si512(masks + count + static_cast<std::size_t>(__builtin_popcount(low)),
                        _mm512_maskz_compress_epi64(high, high_mask));
    count += static_cast<std::size_t>(__builtin_popcount(which));
    if (count > kRoom - 16) put();
  }

  void put() {
    for (std::size_t i = 0; i < count; ++i) {
      table[words[i]] |= masks[i];
      touched[words[i] >> 3] = 1;
    }
    count = 0;
  }

  std::uint64_t* const table;
  std::uint8_t* const touched;
  std::size_t count = 0;
  alignas(64) std::uint32_t words[kRoom + 16];
  alignas(64) std::uint64_t masks[kRoom + 16];
};

/// Sixteen rays side by side.
class Sixteen {
 public:
  Sixteen(const WalkInput& in, const std::uint32_t* rays, Pending& pending)
      : pending_(pending),
        low_(*in.rays, _mm256_loadu_si256(reinterpret_cast<const __m256i*>(rays))),
        high_(*in.rays, _mm256_loadu_si256(reinterpret_cast<const __m256i*>(rays + 8))),
        axis_x_(_mm512_set1_epi32(static_cast<int>(in.axis_mask[0]))),
        axis_y_(_mm512_set1_epi32(static_cast<int>(in.axis_mask[1]))),
        axis_z_(_mm512_set1_epi32(static_cast<int>(in.axis_mask[2]))) {
    alignas(64) std::uint32_t mirror[16], end[16];
    alignas(64) double length[16];
    for (int lane = 0; lane < 16; ++lane) {
      const std::uint32_t ray = rays[lane];
      mirror[lane] = static_cast<std::uint32_t>(mirror_of(in, in.rays->negative[ray]));
      end[lane] = static_cast<std::uint32_t>(in.end_address[ray]);
      length[lane] = in.rays->length[ray];
      const std::uint32_t steps = untested(in.rays->steps[ray]);
      untested_ = steps < untested_ ? steps : untested_;
    }
    mirror_ = _mm512_load_si512(mirror);
    end_ = _mm512_load_si512(end);
    low_length_ = _mm512_load_pd(length);
    high_length_ = _mm512_load_pd(length + 8);
    const __m512i origin = _mm512_set1_epi32(static_cast<int>(in.origin_address));
    address_ = _mm512_xor_si512(origin, mirror_);
    word_ = _mm512_srli_epi32(origin, 6);
  }

  void walk() {
    mark(0xffff);
    for (std::uint32_t k = 1; k < untested_; ++k) {
      step();
      mark(0xffff);
    }
    for (__mmask16 walking = 0xffff;;) {
      step();
      const __mmask16 past = _mm512_kunpackb(high_.ends(high_length_), low_.ends(low_length_));
      walking &= static_cast<__mmask16>(~(past | _mm512_cmpeq_epi32_mask(address_, end_)));
      if (!walking) break;
      mark(walking);
    }
    pending_.add(0xffff, word_, low_mask_, high_mask_);
  }

 private:
  void step() {
    const Eight::Axes low = low_.step(), high = high_.step();
    const __mmask16 along_x = _mm512_kunpackb(high.x, low.x), along_y = _mm512_kunpackb(high.y, low.y);
    const __m512i axis = _mm512_mask_mov_epi32(_mm512_mask_mov_epi32(axis_z_, along_x, axis_x_), along_y, axis_y_);
    const __m512i others_full = _mm512_ternarylogic_epi32(address_, axis, axis, 0xf3);  // address | ~axis
    const __m512i stepped = _mm512_sub_epi32(others_full, _mm512_set1_epi32(-1));
    address_ = _mm512_ternarylogic_epi32(axis, stepped, address_, 0xca);  // axis ? stepped : address
  }

  void mark(__mmask16 walking) {
    const __m512i real = _mm512_xor_si512(address_, mirror_);
    const __m512i word = _mm512_srli_epi32(real, 6);
    const __mmask16 left = _mm512_mask_cmpneq_epi32_mask(walking, word, word_);
    pending_.add(left, word_, low_mask_, high_mask_);
    const __m512i one = _mm512_set1_epi64(1);
    const __m512i low_bit = _mm512_rolv_epi64(one, _mm512_cvtepu32_epi64(_mm512_castsi512_si256(real)));
    const __m512i high_bit = _mm512_rolv_epi64(one, _mm512_cvtepu32_epi64(_mm512_extracti64x4_epi64(real, 1)));
    const __mmask8 low = static_cast<__mmask8>(walking), high = static_cast<__mmask8>(walking >> 8);
    const __mmask8 low_stays = static_cast<__mmask8>(~left), high_stays = static_cast<__mmask8>(~left >> 8);
    low_mask_ = _mm512_maskz_mov_epi64(low_stays, low_mask_);
    high_mask_ = _mm512_maskz_mov_epi64(high_stays, high_mask_);
    low_mask_ = _mm512_mask_or_epi64(low_mask_, low, low_mask_, low_bit);
    high_mask_ = _mm512_mask_or_epi64(high_mask_, high, high_mask_, high_bit);
    word_ = _mm512_mask_mov_epi32(word_, walking, word);
  }

  Pending& pending_;
  Eight low_, high_;
  const __m512i axis_x_, axis_y_, axis_z_;
  __m512i mirror_, end_, address_, word_;
  __m512d low_length_, high_length_;
  __m512i low_mask_ = _mm512_setzero_si512(), high_mask_ = _mm512_setzero_si512();
  std::uint32_t untested_ = ~0u;
};

void walk(const WalkInput& in) {
  if (!in.table) {
    for (std::size_t i = 0; i < in.count; ++i) walk_one(in, in.order[i]);
    return;
  }
  Pending pending(in);
  for (std::size_t i = 0; i < in.count; i += 16) Sixteen(in, in.order + i, pending).walk();
  pending.put();
}

}  // namespace

const Kernels kAvx512Kernels{start_rays, walk, collect_chunk<Avx512>, update_bricks<Avx512>};

}  // namespace uwsim::bricks
