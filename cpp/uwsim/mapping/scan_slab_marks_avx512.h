#pragma once

#include "uwsim/mapping/scan_pending_avx512.h"

/// Only the files named scan_kernels_*avx512.cpp may include it, after <immintrin.h>.
namespace uwsim::bricks {
namespace {

/// What a class of rays has in common: main axis and direction.
struct Way {
  std::uint32_t mask_a, mask_b, mask_z;  ///< of addresses
  std::uint32_t tile_a, tile_b;          ///< the same without the two lowest bits
  std::uint32_t origin;                  ///< address
  int a, b;                              ///< the axes
  bool back;                             ///< against the main axis
  int entry;                             ///< slabs of the origin's column of four that lie behind it
  int at_a, at_b;                        ///< the origin within its tile of 4 x 4 voxels

  Way(const WalkInput& in, unsigned way) {
    a = way > 2 ? 1 : 0;
    b = 1 - a;
    back = way == 2 || way == 4;
    mask_a = static_cast<std::uint32_t>(in.axis_mask[a]);
    mask_b = static_cast<std::uint32_t>(in.axis_mask[b]);
    mask_z = static_cast<std::uint32_t>(in.axis_mask[2]);
    tile_a = mask_a & ~(9u << a);
    tile_b = mask_b & ~(9u << b);
    origin = static_cast<std::uint32_t>(in.origin_address);
    const auto within = [&](int axis) { return static_cast<int>((origin >> axis & 1) | (origin >> (axis + 2) & 2)); };
    at_a = within(a);
    at_b = within(b);
    entry = back ? 3 - at_a : at_a;
  }
};

/// Adds one to the bits of `mask`.
__m512i add_one(__m512i address, __m512i mask) {
  const __m512i others_full = _mm512_ternarylogic_epi32(address, mask, mask, 0xf3);  // address | ~mask
  return _mm512_ternarylogic_epi32(mask, _mm512_sub_epi32(others_full, _mm512_set1_epi32(-1)), address, 0xca);
}
__m512i take_one(__m512i address, __m512i mask) {
  const __m512i alone = _mm512_and_si512(address, mask);
  return _mm512_ternarylogic_epi32(mask, _mm512_add_epi32(alone, _mm512_set1_epi32(-1)), address, 0xca);
}

/// Marks of tiles that wait for the rays to be sure: 8 x 4 voxels of the middle and the main axis.
struct Marks {
  static constexpr std::size_t kRoom = 1024;
  alignas(64) std::uint32_t tiles[kRoom + 64];
  alignas(64) std::uint32_t masks[kRoom + 64];
  std::size_t count = 0;

  /// Neighbours that mark the same tile do it once. A run of up to eight ends up in its first.
  void add(__m512i tile, __m512i mask) {
    merge<1>(tile, mask);
    merge<2>(tile, mask);
    merge<4>(tile, mask);
    const __m512i before = _mm512_alignr_epi32(tile, tile, 15);
    const __mmask16 first = static_cast<__mmask16>(_mm512_cmpneq_epi32_mask(tile, before) | 0x0101);
    const __mmask16 which = _mm512_mask_test_epi32_mask(first, mask, mask);
    _mm512_storeu_si512(tiles + count, _mm512_maskz_compress_epi32(which, tile));
    _mm512_storeu_si512(masks + count, _mm512_maskz_compress_epi32(which, mask));
    count += static_cast<std::size_t>(__builtin_popcount(which));
  }

  template <int kBy>
  static void merge(__m512i tile, __m512i& mask) {
    const __mmask16 same = _mm512_cmpeq_epi32_mask(tile, _mm512_alignr_epi32(tile, tile, kBy));
    mask = _mm512_mask_or_epi32(mask, same, mask, _mm512_alignr_epi32(mask, mask, kBy));
  }

  /// To half words in Morton order.
  void put(const Way& way, Pending& pending) {
    std::size_t halves = 0;
    for (std::size_t i = 0; i < count; i += 16) {
      const __mmask16 lanes = static_cast<__mmask16>(count - i < 16 ? (1u << (count - i)) - 1 : 0xffff);
      const __m512i tile = _mm512_load_si512(tiles + i), mask = _mm512_load_si512(masks + i);
      halves = half_words(way, pending, halves, lanes, tile, _mm512_and_si512(mask, _mm512_set1_epi32(0xffff)));
      halves = half_words(way, pending, halves, lanes, add_one(tile, _mm512_set1_epi32(static_cast<int>(way.tile_b))),
                          _mm512_srli_epi32(mask, 16));
    }
    pending.put(halves);
    count = 0;
  }

 private:
  /// Bits (b1 b0 a1 a0) of a tile's mask to Morton's (y1 x1 0 y0 x0).
  static std::size_t half_words(const Way& way, Pending& pending, std::size_t at, __mmask16 lanes, __m512i tile,
                                __m512i mask) {
    mask = swapped<2>(mask, 0x0c0c);
    if (way.a == 1) mask = swapped<4>(swapped<1>(mask, 0x2222), 0x00f0);
    mask = _mm512_and_si512(_mm512_or_si512(mask, _mm512_slli_epi32(mask, 8)), _mm512_set1_epi32(0x00ff00ff));
    mask = _mm512_and_si512(_mm512_or_si512(mask, _mm512_slli_epi32(mask, 4)), _mm512_set1_epi32(0x0f0f0f0f));
    mask = _mm512_sllv_epi32(mask, _mm512_and_si512(tile, _mm512_set1_epi32(4)));  // z0
    const __mmask16 which = _mm512_mask_test_epi32_mask(lanes, mask, mask);
    _mm512_storeu_si512(pending.halves + at, _mm512_maskz_compress_epi32(which, _mm512_srli_epi32(tile, 5)));
    _mm512_storeu_si512(pending.masks + at, _mm512_maskz_compress_epi32(which, mask));
    return at + static_cast<std::size_t>(__builtin_popcount(which));
  }

  /// Exchanges the bits of `low` with those kBy above them.
  template <int kBy>
  static __m512i swapped(__m512i bits, int low) {
    const __m512i apart = _mm512_xor_si512(bits, _mm512_srli_epi32(bits, kBy));
    const __m512i change = _mm512_and_si512(apart, _mm512_set1_epi32(low));
    return _mm512_xor_si512(bits, _mm512_xor_si512(change, _mm512_slli_epi32(change, kBy)));
  }
};

}  // namespace
}  // namespace uwsim::bricks
