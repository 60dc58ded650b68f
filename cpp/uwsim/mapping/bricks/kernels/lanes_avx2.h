#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

/// Eight numbers of 32 bits side by side, and one of double precision; lanes_avx512.h explains the names. Only the
/// files named scan_kernels_*avx2.cpp may include this file, after <immintrin.h>.
namespace uwsim::bricks {
namespace {

using Lanes = __m256i;
constexpr std::size_t kLanes = 8;

struct LaneMask {
  __m256i bits;  ///< all bits of each lane that is selected
  friend LaneMask operator&(LaneMask a, LaneMask b) { return {_mm256_and_si256(a.bits, b.bits)}; }
  friend LaneMask operator|(LaneMask a, LaneMask b) { return {_mm256_or_si256(a.bits, b.bits)}; }
  friend LaneMask operator^(LaneMask a, LaneMask b) { return {_mm256_xor_si256(a.bits, b.bits)}; }
};
inline LaneMask without(LaneMask a, LaneMask b) { return {_mm256_andnot_si256(b.bits, a.bits)}; }
inline unsigned bits_of(LaneMask mask) {
  return static_cast<unsigned>(_mm256_movemask_ps(_mm256_castsi256_ps(mask.bits)));
}
inline bool any(LaneMask mask) { return !_mm256_testz_si256(mask.bits, mask.bits); }
inline std::size_t count(LaneMask mask) { return static_cast<std::size_t>(__builtin_popcount(bits_of(mask))); }
inline LaneMask first_lanes(std::size_t n) {
  const __m256i lane = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
  return {_mm256_cmpgt_epi32(_mm256_set1_epi32(static_cast<int>(n < kLanes ? n : kLanes)), lane)};
}

inline Lanes all_lanes(std::uint32_t value) { return _mm256_set1_epi32(static_cast<int>(value)); }
inline Lanes load(const std::uint32_t* from) { return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(from)); }
inline void store(std::uint32_t* to, Lanes x) { _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), x); }
inline Lanes gather(const std::uint32_t* column, Lanes index) {
  return _mm256_i32gather_epi32(reinterpret_cast<const int*>(column), index, 4);
}

inline Lanes plus(Lanes a, Lanes b) { return _mm256_add_epi32(a, b); }
inline Lanes minus(Lanes a, Lanes b) { return _mm256_sub_epi32(a, b); }
inline Lanes smaller(Lanes a, Lanes b) { return _mm256_min_epu32(a, b); }
inline Lanes not_negative(Lanes x) { return _mm256_max_epi32(x, _mm256_setzero_si256()); }
inline Lanes sign(Lanes x) { return _mm256_srai_epi32(x, 31); }
inline LaneMask is_less(Lanes a, Lanes b) {
  const __m256i half = all_lanes(0x80000000);
  return {_mm256_cmpgt_epi32(_mm256_xor_si256(b, half), _mm256_xor_si256(a, half))};
}
inline LaneMask is_equal(Lanes a, Lanes b) { return {_mm256_cmpeq_epi32(a, b)}; }
inline LaneMask has_none(Lanes x, Lanes bits) { return is_equal(_mm256_and_si256(x, bits), _mm256_setzero_si256()); }
inline LaneMask has_any(Lanes x, Lanes bits) { return {_mm256_xor_si256(has_none(x, bits).bits, all_lanes(~0u))}; }
inline Lanes select(LaneMask mask, Lanes yes, Lanes no) { return _mm256_blendv_epi8(no, yes, mask.bits); }
inline Lanes only(LaneMask mask, Lanes x) { return _mm256_and_si256(mask.bits, x); }
inline Lanes plus(LaneMask mask, Lanes a, Lanes b) { return plus(a, only(mask, b)); }
inline Lanes join(LaneMask mask, Lanes a, Lanes b) { return _mm256_or_si256(a, only(mask, b)); }
inline Lanes without(Lanes x, LaneMask mask) { return _mm256_andnot_si256(mask.bits, x); }

inline Lanes without(Lanes a, Lanes b) { return _mm256_andnot_si256(b, a); }
inline Lanes with_others(Lanes a, Lanes b) { return _mm256_or_si256(a, _mm256_xor_si256(b, all_lanes(~0u))); }
inline Lanes blend(Lanes bits, Lanes yes, Lanes no) {
  return _mm256_or_si256(_mm256_and_si256(bits, yes), _mm256_andnot_si256(bits, no));
}
inline Lanes join(Lanes a, Lanes b, Lanes c) { return _mm256_or_si256(_mm256_or_si256(a, b), c); }
inline Lanes differences(Lanes a, Lanes b, Lanes within) { return _mm256_and_si256(_mm256_xor_si256(a, b), within); }

template <int kBy>
inline Lanes shift_up(Lanes x) {
  return _mm256_slli_epi32(x, kBy);
}
template <int kBy>
inline Lanes shift_down(Lanes x) {
  return _mm256_srli_epi32(x, kBy);
}
template <int kBy>
inline Lanes rotate_up(Lanes x) {
  return _mm256_or_si256(_mm256_slli_epi32(x, kBy), _mm256_srli_epi32(x, 32 - kBy));
}
inline Lanes shift_each_up(Lanes x, Lanes by) { return _mm256_sllv_epi32(x, by); }
inline Lanes rotate_each_up(Lanes x, Lanes by) {
  return _mm256_or_si256(_mm256_sllv_epi32(x, by), _mm256_srlv_epi32(x, minus(all_lanes(32), by)));
}
inline Lanes bit_of_each(Lanes place) {
  return _mm256_sllv_epi32(all_lanes(1), _mm256_and_si256(place, all_lanes(31)));
}

constexpr int kRun = 4;  // runs of eight take slower instructions, and longer altogether
template <int kBy>
Lanes next_lanes(Lanes x) {
  return _mm256_shuffle_epi32(x, (kBy & 3) | ((kBy + 1) & 3) << 2 | ((kBy + 2) & 3) << 4 | ((kBy + 3) & 3) << 6);
}
inline Lanes previous_lanes(Lanes x) { return next_lanes<3>(x); }
inline LaneMask starts_of_runs() { return {_mm256_setr_epi32(-1, 0, 0, 0, -1, 0, 0, 0)}; }

inline Lanes look_up(Lanes table, Lanes index) { return _mm256_permutevar8x32_epi32(table, index); }

/// For each set of selected lanes, their numbers in order, one byte each.
constexpr std::array<std::uint64_t, 256> kSelected = [] {
  std::array<std::uint64_t, 256> table{};
  for (unsigned set = 0; set < 256; ++set) {
    int at = 0;
    for (std::uint64_t lane = 0; lane < 8; ++lane) {
      if (set >> lane & 1) table[set] |= lane << (8 * at++);
    }
  }
  return table;
}();
inline Lanes compressed(LaneMask mask, Lanes x) {
  const auto selected = static_cast<long long>(kSelected[bits_of(mask)]);
  return _mm256_permutevar8x32_epi32(x, _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(selected)));
}

using Reals = double;
using Naturals = std::uint32_t;
constexpr std::size_t kReals = 1;

struct RealMask {
  bool bits;
  friend RealMask operator&(RealMask a, RealMask b) { return {static_cast<bool>(a.bits & b.bits)}; }
  friend RealMask operator|(RealMask a, RealMask b) { return {static_cast<bool>(a.bits | b.bits)}; }
};
inline RealMask inverse(RealMask mask) { return {!mask.bits}; }
inline bool any(RealMask mask) { return mask.bits; }
inline bool is_set(RealMask mask, std::size_t) { return mask.bits; }
inline RealMask first_reals(std::size_t) { return {true}; }

inline Reals all_reals(double value) { return value; }
inline Reals load(RealMask, const double* from) { return *from; }
inline Reals distances(RealMask, const std::uint16_t* keys, std::uint32_t origin) {
  return __builtin_abs(static_cast<int>(*keys) - static_cast<int>(origin));
}
inline Reals floor(Reals x) { return __builtin_floor(x); }
inline Reals smaller(Reals a, Reals b) { return a < b ? a : b; }
inline Reals larger(Reals a, Reals b) { return a > b ? a : b; }
inline Reals magnitude(Reals x) { return __builtin_fabs(x); }
inline RealMask is_less(Reals a, Reals b) { return {a < b}; }
inline RealMask is_at_most(Reals a, Reals b) { return {a <= b}; }
inline Reals select(RealMask mask, Reals yes, Reals no) { return mask.bits ? yes : no; }
inline Naturals select(RealMask mask, Naturals yes, Naturals no) { return mask.bits ? yes : no; }
inline Naturals all_naturals(std::uint32_t value) { return value; }
inline Naturals truncated(Reals x) { return static_cast<std::uint32_t>(_mm_cvttsd_si64(_mm_set_sd(x))); }
inline void store(RealMask, std::uint32_t* to, Naturals x) { *to = x; }

}  // namespace
}  // namespace uwsim::bricks
