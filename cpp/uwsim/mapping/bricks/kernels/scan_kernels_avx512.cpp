#include <immintrin.h>

#include "uwsim/mapping/bricks/kernels/brick_update.h"
#include "uwsim/mapping/bricks/kernels/mask_collect.h"
#include "uwsim/mapping/bricks/kernels/ray_start_avx512.h"
#include "uwsim/mapping/bricks/kernels/ray_walk_avx512.h"

namespace uwsim::bricks {
namespace {

struct Avx512 {
  static std::uint64_t touched(const std::uint8_t* bytes) {
    const __m512i all = _mm512_loadu_si512(bytes);
    return _mm512_test_epi8_mask(all, all);
  }

  static void zero_touched(std::uint8_t* bytes) { _mm512_storeu_si512(bytes, _mm512_setzero_si512()); }

  static std::uint8_t move_nonzero(std::uint64_t* words, std::uint64_t* out) {
    const __m512i all = _mm512_load_si512(words);
    const __mmask8 which = _mm512_test_epi64_mask(all, all);
    _mm512_storeu_si512(out, _mm512_maskz_compress_epi64(which, all));
    _mm512_store_si512(words, _mm512_setzero_si512());
    return which;
  }

  /// Applies clamped_sum() of log_odds.h to sixteen voxels at a time.
  static std::uint64_t add_misses(float* block, std::uint64_t todo, const OccupancyLogOdds& model) {
    const __m512 miss = _mm512_set1_ps(model.miss), clamping_min = _mm512_set1_ps(model.clamping_min),
                 clamping_max = _mm512_set1_ps(model.clamping_max);
    std::uint64_t at_min = 0;
    for (int i = 0; i < 4; ++i) {
      const __mmask16 lanes = static_cast<__mmask16>(todo >> (16 * i));
      const __m512 old = _mm512_load_ps(block + 16 * i);
      const __m512 sum = _mm512_min_ps(_mm512_max_ps(_mm512_add_ps(old, miss), clamping_min), clamping_max);
      _mm512_mask_store_ps(block + 16 * i, lanes, sum);
      at_min |= static_cast<std::uint64_t>(_mm512_mask_cmp_ps_mask(lanes, sum, clamping_min, _CMP_LE_OQ)) << (16 * i);
    }
    return at_min;
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

}  // namespace

const Kernels kAvx512Kernels{start_eight_at_a_time, walk_thirty_two_at_a_time, collect_chunk<Avx512>,
                             update_bricks<Avx512>};

}  // namespace uwsim::bricks
