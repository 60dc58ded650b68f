#pragma once

#include "uwsim/mapping/bricks/kernels/scan_kernels.h"

/// Only the files named scan_kernels_*avx512.cpp may include this file, after <immintrin.h>.
namespace uwsim::bricks {
namespace {

/// A buffer of marks to be written to the table: each mark is the index of a half word (4 x 4 x 2 voxels) and its bits.
/// The caller keeps the number of marks, so that this number stays in a register.
class MarkBuffer {
 public:
  using HalfWord __attribute__((may_alias)) = std::uint32_t;
  static constexpr std::size_t kCapacity = 4096;

  explicit MarkBuffer(const WalkInput& walk)
      : table_(reinterpret_cast<HalfWord*>(walk.table)), touched_(walk.touched) {}

  /// Appends those of sixteen marks that `which` selects, after the first `count` marks; returns the new number of
  /// marks.
  std::size_t append(std::size_t count, __mmask16 which, __m512i half, __m512i mask) {
    _mm512_storeu_si512(halves_ + count, _mm512_maskz_compress_epi32(which, half));
    _mm512_storeu_si512(masks_ + count, _mm512_maskz_compress_epi32(which, mask));
    return count + static_cast<std::size_t>(__builtin_popcount(which));
  }

  /// Writes the first `count` marks. Successive marks often fall into the same word, where each would have to wait for
  /// the previous one to be written. The buffer is therefore written from eight positions in turn.
  void write(std::size_t count) {
    constexpr std::size_t kPlaces = 8;
    const std::size_t stride = count / kPlaces;
    for (std::size_t i = 0; i < stride; ++i) {
      for (std::size_t place = 0; place < kPlaces; ++place) write_one(place * stride + i);
    }
    for (std::size_t i = kPlaces * stride; i < count; ++i) write_one(i);
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

}  // namespace
}  // namespace uwsim::bricks
