#pragma once

#if defined(__SSE2__)
#include <immintrin.h>
#endif

#include <cstddef>
#include <cstdint>
#include <cstring>

// As many doubles at a time as the CPU's vectors hold, for kernels that are compiled once for each instruction set,
// hence the anonymous namespace. (Of wider vectors GCC 12 compares and selects the lanes one by one, with branches.)
// Comparisons produce masks, which select with ?:. So that sums have the same bits everywhere, they are added up in
// kEight lanes, of which kLanes at a time are in a vector.
namespace uwsim {
namespace {

constexpr std::size_t kEight = 8;
#if defined(__AVX512F__)
constexpr std::size_t kLanes = 8;
#elif defined(__AVX2__)
constexpr std::size_t kLanes = 4;
#else
constexpr std::size_t kLanes = 2;
#endif

using DoubleLanes = double __attribute__((vector_size(kLanes * sizeof(double))));
using IndexLanes = long long __attribute__((vector_size(kLanes * sizeof(double))));

[[maybe_unused]] inline DoubleLanes load_lanes(const double* numbers) {
  DoubleLanes out;
  std::memcpy(&out, numbers, sizeof out);
  return out;
}

[[maybe_unused]] inline void store_lanes(DoubleLanes lanes, double* numbers) {
  std::memcpy(numbers, &lanes, sizeof lanes);
}

/// Returns true if any lane of a mask (-1 or 0) is true.
[[maybe_unused]] inline bool any_of(IndexLanes mask) {
#if defined(__AVX512F__)
  return _mm512_test_epi64_mask((__m512i)mask, (__m512i)mask) != 0;
#elif defined(__AVX2__)
  return _mm256_movemask_pd((__m256d)mask) != 0;
#elif defined(__SSE2__)
  return _mm_movemask_pd((__m128d)mask) != 0;
#else
  return mask[0] != 0 || mask[1] != 0;
#endif
}

[[maybe_unused]] inline double sum_of_eight(const double* s) {
  return ((s[0] + s[1]) + (s[2] + s[3])) + ((s[4] + s[5]) + (s[6] + s[7]));
}

}  // namespace
}  // namespace uwsim
