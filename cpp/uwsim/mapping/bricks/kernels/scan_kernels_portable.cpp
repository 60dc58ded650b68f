#include "uwsim/mapping/bricks/kernels/brick_update.h"
#include "uwsim/mapping/bricks/kernels/mask_collect.h"
#include "uwsim/mapping/bricks/kernels/ray_start.h"
#include "uwsim/mapping/bricks/kernels/ray_walk.h"

namespace uwsim::bricks {
namespace {

struct Portable : ScalarWords {
  static std::uint64_t touched(const std::uint8_t* bytes) {
    std::uint64_t bits = 0;
    for (int i = 0; i < 64; i += 8) {
      std::uint64_t eight;
      __builtin_memcpy(&eight, bytes + i, 8);
      if (eight == 0) continue;
      for (int k = 0; k < 8; ++k) bits |= static_cast<std::uint64_t>(bytes[i + k] != 0) << (i + k);
    }
    return bits;
  }

  static std::uint64_t add_misses(float* block, std::uint64_t todo, const OccupancyLogOdds& model) {
    std::uint64_t at_min = 0;
    for (std::uint64_t bits = todo; bits != 0; bits &= bits - 1) {
      float& value = block[__builtin_ctzll(bits)];
      value = clamped_sum(value, model.miss, model);
      if (value <= model.clamping_min) at_min |= bits & -bits;
    }
    return at_min;
  }

  static void fill(float* block, std::uint64_t bits, float value) {
    for (int i = 0; i < 64; ++i) block[i] = bits >> i & 1 ? value : 0.0f;
  }

  static bool all_equal(const float* block, std::uint64_t bits, float value) {
    for (; bits != 0; bits &= bits - 1) {
      if (block[__builtin_ctzll(bits)] != value) return false;
    }
    return true;
  }
};

}  // namespace

const Kernels kPortableKernels{start_rays, walk_one_by_one, collect_chunk<Portable>, update_bricks<Portable>};

}  // namespace uwsim::bricks
