#include <immintrin.h>

#include "uwsim/mapping/bricks/kernels/brick_update.h"
#include "uwsim/mapping/bricks/kernels/mask_collect.h"
#include "uwsim/mapping/bricks/kernels/ray_start.h"
#include "uwsim/mapping/bricks/kernels/ray_walk_avx2.h"

namespace uwsim::bricks {
namespace {

struct Avx2 : ScalarWords {
  static std::uint64_t touched(const std::uint8_t* bytes) {
    const __m256i* const halves = reinterpret_cast<const __m256i*>(bytes);
    const __m256i zero = _mm256_setzero_si256();
    const auto untouched = [&](int half) {
      return static_cast<std::uint32_t>(
          _mm256_movemask_epi8(_mm256_cmpeq_epi8(_mm256_loadu_si256(halves + half), zero)));
    };
    return ~(static_cast<std::uint64_t>(untouched(1)) << 32 | untouched(0));
  }

  /// Applies clamped_sum() of log_odds.h to eight voxels at a time.
  static std::uint64_t add_misses(float* block, std::uint64_t todo, const OccupancyLogOdds& model) {
    const __m256 miss = _mm256_set1_ps(model.miss), clamping_min = _mm256_set1_ps(model.clamping_min),
                 clamping_max = _mm256_set1_ps(model.clamping_max);
    std::uint64_t at_min = 0;
    for (int i = 0; i < 8; ++i) {
      const std::uint64_t eight = todo >> (8 * i) & 0xff;
      if (eight == 0) continue;
      const __m256i lanes = lanes_of(eight);
      const __m256 old = _mm256_load_ps(block + 8 * i);
      const __m256 sum = _mm256_min_ps(_mm256_max_ps(_mm256_add_ps(old, miss), clamping_min), clamping_max);
      _mm256_store_ps(block + 8 * i, _mm256_blendv_ps(old, sum, _mm256_castsi256_ps(lanes)));
      const unsigned low = static_cast<unsigned>(_mm256_movemask_ps(_mm256_cmp_ps(sum, clamping_min, _CMP_LE_OQ)));
      at_min |= (low & eight) << (8 * i);
    }
    return at_min;
  }

  static void fill(float* block, std::uint64_t bits, float value) {
    const __m256 values = _mm256_set1_ps(value);
    for (int i = 0; i < 8; ++i) {
      _mm256_store_ps(block + 8 * i, _mm256_and_ps(values, _mm256_castsi256_ps(lanes_of(bits >> (8 * i)))));
    }
  }

  static bool all_equal(const float* block, std::uint64_t bits, float value) {
    const __m256 wanted = _mm256_set1_ps(value);
    for (int i = 0; i < 8; ++i) {
      const int other = _mm256_movemask_ps(_mm256_cmp_ps(_mm256_load_ps(block + 8 * i), wanted, _CMP_NEQ_UQ));
      if (static_cast<unsigned>(other) & (bits >> (8 * i) & 0xff)) return false;
    }
    return true;
  }

 private:
  /// Expands the lowest eight bits to a mask of eight lanes.
  static __m256i lanes_of(std::uint64_t bits) {
    const __m256i bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
    return _mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32(static_cast<int>(bits)), bit), bit);
  }
};

}  // namespace

const Kernels kAvx2Kernels{start_rays, walk_eight_at_a_time, collect_chunk<Avx2>, update_bricks<Avx2>};

}  // namespace uwsim::bricks
