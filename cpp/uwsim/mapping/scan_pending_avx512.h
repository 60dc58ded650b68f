#pragma once

#include "uwsim/mapping/scan_kernels_common.h"

/// Only the files named scan_kernels_*avx512.cpp may include it, after <immintrin.h>.
namespace uwsim::bricks {
namespace {

/// Half words of the table that rays have left, with the bits they set there, until they are put down.
struct Pending {
  using HalfWord __attribute__((may_alias)) = std::uint32_t;
  static constexpr std::size_t kRoom = 4096;

  HalfWord* table;
  std::uint8_t* touched;
  alignas(64) std::uint32_t halves[kRoom];
  alignas(64) std::uint32_t masks[kRoom];

  /// Neighbours are often of one word, and each would have to wait for the one before it: so they take turns with
  /// others, from far apart.
  void put(std::size_t count) {
    constexpr std::size_t kTurns = 8;
    const std::size_t stride = count / kTurns;
    for (std::size_t i = 0; i < stride; ++i) {
      for (std::size_t turn = 0; turn < kTurns; ++turn) put_one(turn * stride + i);
    }
    for (std::size_t i = kTurns * stride; i < count; ++i) put_one(i);
  }

  void put_one(std::size_t i) {
    table[halves[i]] |= masks[i];
    touched[halves[i] >> 4] = 1;
  }
};

}  // namespace
}  // namespace uwsim::bricks
