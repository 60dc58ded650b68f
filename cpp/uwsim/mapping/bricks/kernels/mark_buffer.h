#pragma once

#include "uwsim/mapping/bricks/kernels/scan_kernels.h"

/// Compiled into the scan_kernels_*.cpp that include lanes_avx2.h or lanes_avx512.h before it.
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

  /// Appends those of the lanes' marks that `which` selects, after the first `marks` marks; returns the new number of
  /// marks.
  std::size_t append(std::size_t marks, LaneMask which, Lanes half, Lanes mask) {
    store(halves_ + marks, compressed(which, half));
    store(masks_ + marks, compressed(which, mask));
    return marks + count(which);
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

}  // namespace
}  // namespace uwsim::bricks
