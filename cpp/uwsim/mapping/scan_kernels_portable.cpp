#include "uwsim/mapping/scan_kernels_common.h"

namespace uwsim::bricks {
namespace {

struct Portable {
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

  static void wipe(std::uint8_t* bytes) { __builtin_memset(bytes, 0, 64); }

  static std::uint8_t compress(std::uint64_t* words, std::uint64_t* out) {
    unsigned which = 0;
    for (unsigned w = 0; w < 8; ++w) {
      *out = words[w];
      out += words[w] != 0;
      which |= static_cast<unsigned>(words[w] != 0) << w;
      words[w] = 0;
    }
    return static_cast<std::uint8_t>(which);
  }

  static std::uint64_t miss(float* block, std::uint64_t todo, const SensorModel& model) {
    std::uint64_t low = 0;
    for (std::uint64_t bits = todo; bits != 0; bits &= bits - 1) {
      float& value = block[__builtin_ctzll(bits)];
      value = clamped(value + model.miss, model);
      if (value <= model.lowest) low |= bits & -bits;
    }
    return low;
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

void walk(const WalkInput& in) {
  for (std::size_t i = 0; i < in.count; ++i) walk_one(in, in.order[i]);
}

}  // namespace

const Kernels kPortableKernels{start_rays, walk, collect_chunk<Portable>, update_bricks<Portable>, nullptr};

}  // namespace uwsim::bricks
