#pragma once

#include "uwsim/mapping/bricks/kernels/scan_kernels.h"

/// Arithmetic on sixteen voxel addresses (address_layout.h). Only the files named scan_kernels_*avx512.cpp may include
/// this file, after <immintrin.h>.
namespace uwsim::bricks {
namespace {

__m512i all_lanes(std::uint32_t value) { return _mm512_set1_epi32(static_cast<int>(value)); }

/// Adds one to the bits of `mask`, as if they were adjacent.
__m512i add_one(__m512i address, __m512i mask) {
  const __m512i others_full = _mm512_ternarylogic_epi32(address, mask, mask, 0xf3);  // address | ~mask
  const __m512i added = _mm512_sub_epi32(others_full, _mm512_set1_epi32(-1));
  return _mm512_ternarylogic_epi32(mask, added, address, 0xca);  // mask ? added : address
}

[[maybe_unused]] __m512i subtract_one(__m512i address, __m512i mask) {
  const __m512i alone = _mm512_and_si512(address, mask);
  return _mm512_ternarylogic_epi32(mask, _mm512_add_epi32(alone, _mm512_set1_epi32(-1)), address, 0xca);
}

}  // namespace
}  // namespace uwsim::bricks
