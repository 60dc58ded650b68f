#pragma once

#if defined(__SSE2__)
#include <immintrin.h>
#endif

#include <cstdint>

/// Arithmetic on sixteen values at once. It uses the compiler's vector types with the width of the CPU's registers; the
/// same source is compiled for each instruction set (kernels_*.cpp). Each operation is one IEEE operation per lane,
/// without fused multiply-add, so that all builds produce the same bits. For use in those files only: everything here
/// is local to the file that includes it.
namespace uwsim {
namespace {

constexpr int kLanes = 16;
#if defined(__AVX512F__)
constexpr int kNativeBytes = 64;
#elif defined(__AVX2__)
constexpr int kNativeBytes = 32;
#else
constexpr int kNativeBytes = 16;
#endif

#define UWSIM_LANES static inline __attribute__((always_inline))
#define UWSIM_INLINE inline __attribute__((always_inline))
#define UWSIM_UNROLLED _Pragma("GCC unroll 8") for (int p = 0; p < kParts; ++p)

template <typename T>
struct Lanes;
using Float = Lanes<float>;
using Int = Lanes<std::int32_t>;
using Unsigned = Lanes<std::uint32_t>;
using Double = Lanes<double>;
using Wide = Lanes<std::uint64_t>;

/// A vector of the CPU's own width, and the same anywhere in memory.
template <typename T>
struct Native;
#define UWSIM_NATIVE(T)                                                                           \
  template <>                                                                                     \
  struct Native<T> {                                                                              \
    using Part = T __attribute__((vector_size(kNativeBytes)));                                    \
    using InMemory = T __attribute__((vector_size(kNativeBytes), aligned(sizeof(T)), may_alias)); \
  };
UWSIM_NATIVE(float)
UWSIM_NATIVE(std::int32_t)
UWSIM_NATIVE(std::uint32_t)
UWSIM_NATIVE(double)
UWSIM_NATIVE(std::uint64_t)
#undef UWSIM_NATIVE

/// Sixteen values. Comparisons of 32-bit values produce masks: -1 for true, 0 for false.
template <typename T>
struct Lanes {
  static constexpr int kParts = kLanes * static_cast<int>(sizeof(T)) / kNativeBytes;
  using Part = typename Native<T>::Part;

  Part part[kParts];

  UWSIM_INLINE Lanes() { UWSIM_UNROLLED part[p] = Part{}; }
  UWSIM_INLINE Lanes(T value) {               // NOLINT(google-explicit-constructor): numbers mix with lanes
    UWSIM_UNROLLED part[p] = value - Part{};  // x - 0 is x, also if x is -0, and needs no instruction
  }

  UWSIM_INLINE T operator[](int k) const { return reinterpret_cast<const T*>(part)[k]; }
  UWSIM_INLINE T& operator[](int k) { return reinterpret_cast<T*>(part)[k]; }

#define UWSIM_OPERATOR(op)                                       \
  friend UWSIM_INLINE Lanes operator op(Lanes a, Lanes b) {      \
    UWSIM_UNROLLED a.part[p] = a.part[p] op b.part[p];           \
    return a;                                                    \
  }                                                              \
  friend UWSIM_INLINE Lanes& operator op##=(Lanes& a, Lanes b) { \
    UWSIM_UNROLLED a.part[p] = a.part[p] op b.part[p];           \
    return a;                                                    \
  }
  UWSIM_OPERATOR(+)
  UWSIM_OPERATOR(-)
  UWSIM_OPERATOR(*)
  UWSIM_OPERATOR(/)
  UWSIM_OPERATOR(&)
  UWSIM_OPERATOR(|)
  UWSIM_OPERATOR(^)
#undef UWSIM_OPERATOR
#define UWSIM_COMPARISON(op)                              \
  friend UWSIM_INLINE Int operator op(Lanes a, Lanes b) { \
    Int mask;                                             \
    UWSIM_UNROLLED mask.part[p] = a.part[p] op b.part[p]; \
    return mask;                                          \
  }
  UWSIM_COMPARISON(<)
  UWSIM_COMPARISON(>)
  UWSIM_COMPARISON(<=)
  UWSIM_COMPARISON(>=)
  UWSIM_COMPARISON(==)
#undef UWSIM_COMPARISON
  friend UWSIM_INLINE Lanes operator>>(Lanes a, int bits) {
    UWSIM_UNROLLED a.part[p] = a.part[p] >> bits;
    return a;
  }
  friend UWSIM_INLINE Lanes operator<<(Lanes a, int bits) {
    UWSIM_UNROLLED a.part[p] = a.part[p] << bits;
    return a;
  }
  friend UWSIM_INLINE Lanes operator-(Lanes a) {
    UWSIM_UNROLLED a.part[p] = -a.part[p];
    return a;
  }
  friend UWSIM_INLINE Lanes operator~(Lanes a) {
    UWSIM_UNROLLED a.part[p] = ~a.part[p];
    return a;
  }
};

template <typename T>
struct HalfNative;
template <>
struct HalfNative<float> {
  using Part = float __attribute__((vector_size(kNativeBytes / 2)));
};
template <>
struct HalfNative<std::uint32_t> {
  using Part = std::uint32_t __attribute__((vector_size(kNativeBytes / 2)));
};

/// The two halves of a vector, and the vector of two halves. They stay in registers: memory would make every load wait
/// for the two stores that it spans.
#if defined(__AVX512F__)
#define UWSIM_LOW_LANES 0, 1, 2, 3, 4, 5, 6, 7
#define UWSIM_HIGH_LANES 8, 9, 10, 11, 12, 13, 14, 15
#elif defined(__AVX2__)
#define UWSIM_LOW_LANES 0, 1, 2, 3
#define UWSIM_HIGH_LANES 4, 5, 6, 7
#else
#define UWSIM_LOW_LANES 0, 1
#define UWSIM_HIGH_LANES 2, 3
#endif

/// Conversion to values of twice or half the size: each part of the wider type contains half a part of the narrower.
template <typename To, typename From>
requires(sizeof(To) == 2 * sizeof(From)) UWSIM_LANES Lanes<To> widened(Lanes<From> x) {
  constexpr int kParts = Lanes<From>::kParts;
  using Part = typename Native<To>::Part;
  Lanes<To> y;
  UWSIM_UNROLLED {
    y.part[2 * p] = __builtin_convertvector(__builtin_shufflevector(x.part[p], x.part[p], UWSIM_LOW_LANES), Part);
    y.part[2 * p + 1] = __builtin_convertvector(__builtin_shufflevector(x.part[p], x.part[p], UWSIM_HIGH_LANES), Part);
  }
  return y;
}
template <typename To, typename From>
requires(2 * sizeof(To) == sizeof(From)) UWSIM_LANES Lanes<To> narrowed(Lanes<From> x) {
  constexpr int kParts = Lanes<To>::kParts;
  using Half = typename HalfNative<To>::Part;
  Lanes<To> y;
  UWSIM_UNROLLED {
    y.part[p] =
        __builtin_shufflevector(__builtin_convertvector(x.part[2 * p], Half),
                                __builtin_convertvector(x.part[2 * p + 1], Half), UWSIM_LOW_LANES, UWSIM_HIGH_LANES);
  }
  return y;
}
UWSIM_LANES Int to_int(Float x) {
  constexpr int kParts = Int::kParts;
  Int y;
  UWSIM_UNROLLED y.part[p] = __builtin_convertvector(x.part[p], Int::Part);
  return y;
}
UWSIM_LANES Float to_float(Int x) {
  constexpr int kParts = Int::kParts;
  Float y;
  UWSIM_UNROLLED y.part[p] = __builtin_convertvector(x.part[p], Float::Part);
  return y;
}
/// Reinterprets the bits as another type.
template <typename To, typename From>
UWSIM_LANES Lanes<To> bits_as(Lanes<From> x) {
  constexpr int kParts = Lanes<To>::kParts;
  Lanes<To> y;
  UWSIM_UNROLLED y.part[p] = (typename Native<To>::Part)x.part[p];
  return y;
}

/// Products of the low halves.
UWSIM_LANES Wide times_low(Wide a, std::uint32_t b) {
  constexpr int kParts = Wide::kParts;
  const Wide many(std::uint64_t{b});
#if defined(__AVX512F__)
  UWSIM_UNROLLED a.part[p] = (Wide::Part)_mm512_mul_epu32((__m512i)a.part[p], (__m512i)many.part[p]);
#elif defined(__AVX2__)
  UWSIM_UNROLLED a.part[p] = (Wide::Part)_mm256_mul_epu32((__m256i)a.part[p], (__m256i)many.part[p]);
#elif defined(__SSE2__)
  UWSIM_UNROLLED a.part[p] = (Wide::Part)_mm_mul_epu32((__m128i)a.part[p], (__m128i)many.part[p]);
#else
  UWSIM_UNROLLED a.part[p] = (a.part[p] & 0xFFFFFFFFu) * many.part[p];
#endif
  return a;
}

UWSIM_LANES Float splat(float value) { return Float(value); }
/// Sixteen values from memory, or to it, a register at a time. (GCC 12 copies whole Lanes in parts of 16 bytes, which
/// a wider load must then wait for.)
template <typename T>
UWSIM_LANES Lanes<T> load(const T* from) {
  constexpr int kParts = Lanes<T>::kParts;
  const auto* const parts = reinterpret_cast<const typename Native<T>::InMemory*>(from);
  Lanes<T> value;
  UWSIM_UNROLLED value.part[p] = parts[p];
  return value;
}
template <typename T>
UWSIM_LANES void store(T* to, Lanes<T> value) {
  constexpr int kParts = Lanes<T>::kParts;
  auto* const parts = reinterpret_cast<typename Native<T>::InMemory*>(to);
  UWSIM_UNROLLED parts[p] = value.part[p];
}

template <typename T>
requires(sizeof(T) == 4) UWSIM_LANES Lanes<T> select(Int mask, Lanes<T> yes, Lanes<T> no) {
  constexpr int kParts = Int::kParts;
  UWSIM_UNROLLED yes.part[p] = mask.part[p] ? yes.part[p] : no.part[p];
  return yes;
}
/// Returns true if any lane of a mask (-1 or 0) is true.
UWSIM_LANES bool any(Int mask) {
  Int::Part found = mask.part[0];
  for (int p = 1; p < Int::kParts; ++p) found |= mask.part[p];
#if defined(__AVX512F__)
  return _mm512_test_epi32_mask((__m512i)found, (__m512i)found) != 0;
#elif defined(__AVX2__)
  return _mm256_movemask_ps((__m256)found) != 0;
#elif defined(__SSE2__)
  return _mm_movemask_ps((__m128)found) != 0;
#else
  for (int k = 0; k < kLanes / Int::kParts; ++k) {
    if (found[k] != 0) return true;
  }
  return false;
#endif
}
/// min is a < b ? a : b, and max is a > b ? a : b; each is a single CPU instruction on x86-64.
UWSIM_LANES Float min(Float a, Float b) {
  constexpr int kParts = Float::kParts;
#if defined(__AVX512F__)
  UWSIM_UNROLLED a.part[p] = _mm512_min_ps(a.part[p], b.part[p]);
#elif defined(__AVX2__)
  UWSIM_UNROLLED a.part[p] = _mm256_min_ps(a.part[p], b.part[p]);
#elif defined(__SSE2__)
  UWSIM_UNROLLED a.part[p] = _mm_min_ps(a.part[p], b.part[p]);
#else
  UWSIM_UNROLLED a.part[p] = a.part[p] < b.part[p] ? a.part[p] : b.part[p];
#endif
  return a;
}
UWSIM_LANES Float max(Float a, Float b) {
  constexpr int kParts = Float::kParts;
#if defined(__AVX512F__)
  UWSIM_UNROLLED a.part[p] = _mm512_max_ps(a.part[p], b.part[p]);
#elif defined(__AVX2__)
  UWSIM_UNROLLED a.part[p] = _mm256_max_ps(a.part[p], b.part[p]);
#elif defined(__SSE2__)
  UWSIM_UNROLLED a.part[p] = _mm_max_ps(a.part[p], b.part[p]);
#else
  UWSIM_UNROLLED a.part[p] = a.part[p] > b.part[p] ? a.part[p] : b.part[p];
#endif
  return a;
}
UWSIM_LANES Float clamp(Float x, float low, float high) { return min(max(x, splat(low)), splat(high)); }
UWSIM_LANES Float abs(Float x) { return select(x < 0.0f, -x, x); }
UWSIM_LANES Int floor_int(Float x) {
  const Int whole = to_int(x);
  return whole + (to_float(whole) > x);
}
UWSIM_LANES Float square_root(Float x) {
  constexpr int kParts = Float::kParts;
#if defined(__AVX512F__)
  UWSIM_UNROLLED x.part[p] = _mm512_sqrt_ps(x.part[p]);
#elif defined(__AVX2__)
  UWSIM_UNROLLED x.part[p] = _mm256_sqrt_ps(x.part[p]);
#elif defined(__SSE2__)
  UWSIM_UNROLLED x.part[p] = _mm_sqrt_ps(x.part[p]);
#else
  UWSIM_UNROLLED for (int k = 0; k < kLanes / kParts; ++k) x.part[p][k] = __builtin_sqrtf(x.part[p][k]);
#endif
  return x;
}

}  // namespace
}  // namespace uwsim
