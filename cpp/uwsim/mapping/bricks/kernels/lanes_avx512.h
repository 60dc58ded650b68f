#pragma once

#include <cstddef>
#include <cstdint>

/// Sixteen numbers of 32 bits, and eight of double precision, side by side. lanes_avx2.h has the same names for other
/// processors; headers that use them are written once. Lanes that a mask does not select are neither read nor written.
/// Only the files named scan_kernels_*avx512.cpp may include this file, after <immintrin.h>.
namespace uwsim::bricks {
namespace {

using Lanes = __m512i;  // &, | and ^ combine their bits
constexpr std::size_t kLanes = 16;

struct LaneMask {
  __mmask16 bits;
  friend LaneMask operator&(LaneMask a, LaneMask b) { return {static_cast<__mmask16>(a.bits & b.bits)}; }
  friend LaneMask operator|(LaneMask a, LaneMask b) { return {static_cast<__mmask16>(a.bits | b.bits)}; }
  friend LaneMask operator^(LaneMask a, LaneMask b) { return {static_cast<__mmask16>(a.bits ^ b.bits)}; }
};
inline LaneMask without(LaneMask a, LaneMask b) { return {static_cast<__mmask16>(a.bits & ~b.bits)}; }
inline bool any(LaneMask mask) { return mask.bits != 0; }
inline std::size_t count(LaneMask mask) { return static_cast<std::size_t>(__builtin_popcount(mask.bits)); }
inline LaneMask first_lanes(std::size_t n) { return {static_cast<__mmask16>(n < kLanes ? (1u << n) - 1 : 0xffff)}; }

inline Lanes all_lanes(std::uint32_t value) { return _mm512_set1_epi32(static_cast<int>(value)); }
inline Lanes load(const std::uint32_t* from) { return _mm512_loadu_si512(from); }
inline void store(std::uint32_t* to, Lanes x) { _mm512_storeu_si512(to, x); }
inline Lanes gather(const std::uint32_t* column, Lanes index) { return _mm512_i32gather_epi32(index, column, 4); }

inline Lanes plus(Lanes a, Lanes b) { return _mm512_add_epi32(a, b); }
inline Lanes minus(Lanes a, Lanes b) { return _mm512_sub_epi32(a, b); }
inline Lanes smaller(Lanes a, Lanes b) { return _mm512_min_epu32(a, b); }
inline Lanes not_negative(Lanes x) { return _mm512_max_epi32(x, _mm512_setzero_si512()); }
inline Lanes sign(Lanes x) { return _mm512_srai_epi32(x, 31); }  // all bits, or none
inline LaneMask is_less(Lanes a, Lanes b) { return {_mm512_cmplt_epu32_mask(a, b)}; }
inline LaneMask is_equal(Lanes a, Lanes b) { return {_mm512_cmpeq_epi32_mask(a, b)}; }
inline LaneMask has_none(Lanes x, Lanes bits) { return {_mm512_testn_epi32_mask(x, bits)}; }
inline LaneMask has_any(Lanes x, Lanes bits) { return {_mm512_test_epi32_mask(x, bits)}; }
inline Lanes select(LaneMask mask, Lanes yes, Lanes no) { return _mm512_mask_mov_epi32(no, mask.bits, yes); }
inline Lanes only(LaneMask mask, Lanes x) { return _mm512_maskz_mov_epi32(mask.bits, x); }
/// a, with b added or joined in the lanes of the mask.
inline Lanes plus(LaneMask mask, Lanes a, Lanes b) { return _mm512_mask_add_epi32(a, mask.bits, a, b); }
inline Lanes join(LaneMask mask, Lanes a, Lanes b) { return _mm512_mask_or_epi32(a, mask.bits, a, b); }
inline Lanes without(Lanes x, LaneMask mask) { return _mm512_mask_mov_epi32(x, mask.bits, _mm512_setzero_si512()); }

inline Lanes without(Lanes a, Lanes b) { return _mm512_andnot_si512(b, a); }
inline Lanes with_others(Lanes a, Lanes b) { return _mm512_ternarylogic_epi32(a, b, b, 0xf3); }  // a | ~b
/// Selects bit by bit.
inline Lanes blend(Lanes bits, Lanes yes, Lanes no) { return _mm512_ternarylogic_epi32(bits, yes, no, 0xca); }
inline Lanes join(Lanes a, Lanes b, Lanes c) { return _mm512_ternarylogic_epi32(a, b, c, 0xfe); }
inline Lanes differences(Lanes a, Lanes b, Lanes within) { return _mm512_ternarylogic_epi32(a, b, within, 0x28); }

template <int kBy>
inline Lanes shift_up(Lanes x) {
  return _mm512_slli_epi32(x, kBy);
}
template <int kBy>
inline Lanes shift_down(Lanes x) {
  return _mm512_srli_epi32(x, kBy);
}
template <int kBy>
inline Lanes rotate_up(Lanes x) {
  return _mm512_rol_epi32(x, kBy);
}
inline Lanes shift_each_up(Lanes x, Lanes by) { return _mm512_sllv_epi32(x, by); }                // 0 to 31 each
inline Lanes rotate_each_up(Lanes x, Lanes by) { return _mm512_rolv_epi32(x, by); }               // 1 to 31 each
inline Lanes bit_of_each(Lanes place) { return _mm512_rolv_epi32(_mm512_set1_epi32(1), place); }  // modulo 32

/// Lanes are compared within runs of kRun lanes. Lane i is x of lane i + kBy, or of some other lane if that is beyond
/// its run.
constexpr int kRun = 8;
template <int kBy>
Lanes next_lanes(Lanes x) {
  return _mm512_alignr_epi32(x, x, kBy);
}
inline Lanes previous_lanes(Lanes x) { return _mm512_alignr_epi32(x, x, 15); }
inline LaneMask starts_of_runs() { return {0x0101}; }

/// Lane i is table[index of lane i], for indices below eight.
inline Lanes look_up(Lanes table, Lanes index) { return _mm512_permutexvar_epi32(index, table); }
/// The lanes that the mask selects, in order; the lanes after those are unspecified.
inline Lanes compressed(LaneMask mask, Lanes x) { return _mm512_maskz_compress_epi32(mask.bits, x); }

using Reals = __m512d;     // +, -, * and / round after each operation
using Naturals = __m256i;  // as many numbers of 32 bits
constexpr std::size_t kReals = 8;

struct RealMask {
  __mmask8 bits;
  friend RealMask operator&(RealMask a, RealMask b) { return {static_cast<__mmask8>(a.bits & b.bits)}; }
  friend RealMask operator|(RealMask a, RealMask b) { return {static_cast<__mmask8>(a.bits | b.bits)}; }
};
inline RealMask inverse(RealMask mask) { return {static_cast<__mmask8>(~mask.bits)}; }
inline bool any(RealMask mask) { return mask.bits != 0; }
inline bool is_set(RealMask mask, std::size_t lane) { return (mask.bits >> lane & 1) != 0; }
inline RealMask first_reals(std::size_t n) { return {static_cast<__mmask8>(n < kReals ? (1u << n) - 1 : 255)}; }

inline Reals all_reals(double value) { return _mm512_set1_pd(value); }
inline Reals load(RealMask lanes, const double* from) { return _mm512_maskz_loadu_pd(lanes.bits, from); }
/// How far each key is from `origin`.
inline Reals distances(RealMask lanes, const std::uint16_t* keys, std::uint32_t origin) {
  const __m256i all = _mm256_cvtepu16_epi32(_mm_maskz_loadu_epi16(lanes.bits, keys));
  return _mm512_cvtepi32_pd(_mm256_abs_epi32(_mm256_sub_epi32(all, _mm256_set1_epi32(static_cast<int>(origin)))));
}
inline Reals floor(Reals x) { return _mm512_roundscale_pd(x, _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC); }
inline Reals smaller(Reals a, Reals b) { return _mm512_min_pd(a, b); }
inline Reals larger(Reals a, Reals b) { return _mm512_max_pd(a, b); }
inline Reals magnitude(Reals x) { return _mm512_abs_pd(x); }
inline RealMask is_less(Reals a, Reals b) { return {_mm512_cmp_pd_mask(a, b, _CMP_LT_OQ)}; }
inline RealMask is_at_most(Reals a, Reals b) { return {_mm512_cmp_pd_mask(a, b, _CMP_LE_OQ)}; }
inline Reals select(RealMask mask, Reals yes, Reals no) { return _mm512_mask_mov_pd(no, mask.bits, yes); }
inline Naturals select(RealMask mask, Naturals yes, Naturals no) { return _mm256_mask_mov_epi32(no, mask.bits, yes); }
inline Naturals all_naturals(std::uint32_t value) { return _mm256_set1_epi32(static_cast<int>(value)); }
/// The part before the point; unspecified if it does not fit 32 bits.
inline Naturals truncated(Reals x) { return _mm512_cvttpd_epu32(x); }
inline void store(RealMask lanes, std::uint32_t* to, Naturals x) { _mm256_mask_storeu_epi32(to, lanes.bits, x); }

}  // namespace
}  // namespace uwsim::bricks
