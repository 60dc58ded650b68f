#pragma once

#include <cstdint>

/// Arithmetic on sixteen pixels at once, in the compiler's own vector types of the width that the CPU has: one source,
/// compiled for several kinds of CPU (kernel_*.cpp). Every operation is one IEEE operation a lane, without fused
/// multiply-add, so that all builds of it give the same bits. Only for those files: everything here is local to the
/// file that includes it.
namespace uwsim::camera {
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

/// As many as the CPU's vectors hold.
template <typename T>
struct Native;
template <>
struct Native<float> {
  using Part = float __attribute__((vector_size(kNativeBytes)));
};
template <>
struct Native<std::int32_t> {
  using Part = std::int32_t __attribute__((vector_size(kNativeBytes)));
};
template <>
struct Native<std::uint32_t> {
  using Part = std::uint32_t __attribute__((vector_size(kNativeBytes)));
};
template <>
struct Native<double> {
  using Part = double __attribute__((vector_size(kNativeBytes)));
};
template <>
struct Native<std::uint64_t> {
  using Part = std::uint64_t __attribute__((vector_size(kNativeBytes)));
};

/// Sixteen numbers. Comparisons of 32-bit numbers give masks: -1 and 0.
template <typename T>
struct Lanes {
  static constexpr int kParts = kLanes * static_cast<int>(sizeof(T)) / kNativeBytes;
  using Part = typename Native<T>::Part;

  Part part[kParts];

  UWSIM_INLINE Lanes() { UWSIM_UNROLLED part[p] = Part{}; }
  UWSIM_INLINE Lanes(T value) {  // NOLINT(google-explicit-constructor): numbers mix with lanes
    UWSIM_UNROLLED part[p] = Part{} + value;
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

/// Each number as one of twice the width, or of half: each part of the wider holds half a part of the narrower.
template <typename To, typename From>
requires(sizeof(To) == 2 * sizeof(From)) UWSIM_LANES Lanes<To> widened(Lanes<From> x) {
  constexpr int kParts = Lanes<To>::kParts;
  using Half = typename HalfNative<From>::Part;
  Lanes<To> y;
  UWSIM_UNROLLED {
    Half half;
    __builtin_memcpy(&half, reinterpret_cast<const char*>(x.part) + p * sizeof(half), sizeof(half));
    y.part[p] = __builtin_convertvector(half, typename Native<To>::Part);
  }
  return y;
}
template <typename To, typename From>
requires(2 * sizeof(To) == sizeof(From)) UWSIM_LANES Lanes<To> narrowed(Lanes<From> x) {
  constexpr int kParts = Lanes<From>::kParts;
  using Half = typename HalfNative<To>::Part;
  Lanes<To> y;
  UWSIM_UNROLLED {
    const Half half = __builtin_convertvector(x.part[p], Half);
    __builtin_memcpy(reinterpret_cast<char*>(y.part) + p * sizeof(half), &half, sizeof(half));
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
/// The same bits as another type's.
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
  using Words = Native<std::int32_t>::Part;
  const Wide many(std::uint64_t{b});
#if defined(__AVX512F__)
  using Product = long long __attribute__((vector_size(64)));
  UWSIM_UNROLLED a.part[p] =
      (Wide::Part)__builtin_ia32_pmuludq512_mask((Words)a.part[p], (Words)many.part[p], Product{}, -1);
#elif defined(__AVX2__)
  UWSIM_UNROLLED a.part[p] = (Wide::Part)__builtin_ia32_pmuludq256((Words)a.part[p], (Words)many.part[p]);
#else
  UWSIM_UNROLLED a.part[p] = (Wide::Part)__builtin_ia32_pmuludq128((Words)a.part[p], (Words)many.part[p]);
#endif
  return a;
}

UWSIM_LANES Float splat(float value) { return Float(value); }
UWSIM_LANES Float load(const float* from) {
  Float value;
  __builtin_memcpy(value.part, from, sizeof(value.part));
  return value;
}
UWSIM_LANES void store(float* to, Float value) { __builtin_memcpy(to, value.part, sizeof(value.part)); }
UWSIM_LANES Int load(const std::int32_t* from) {
  Int value;
  __builtin_memcpy(value.part, from, sizeof(value.part));
  return value;
}
UWSIM_LANES void store(std::int32_t* to, Int value) { __builtin_memcpy(to, value.part, sizeof(value.part)); }

template <typename T>
requires(sizeof(T) == 4) UWSIM_LANES Lanes<T> select(Int mask, Lanes<T> yes, Lanes<T> no) {
  constexpr int kParts = Int::kParts;
  UWSIM_UNROLLED yes.part[p] = mask.part[p] ? yes.part[p] : no.part[p];
  return yes;
}
UWSIM_LANES bool any(Int mask) {
  std::int32_t found = 0;
  for (int k = 0; k < kLanes; ++k) found |= mask[k];
  return found != 0;
}
/// The CPU's own: a < b ? a : b and a > b ? a : b, in one instruction.
UWSIM_LANES Float min(Float a, Float b) {
  constexpr int kParts = Float::kParts;
#if defined(__AVX512F__)
  UWSIM_UNROLLED a.part[p] = __builtin_ia32_minps512_mask(a.part[p], b.part[p], a.part[p], -1, 4);
#elif defined(__AVX2__)
  UWSIM_UNROLLED a.part[p] = __builtin_ia32_minps256(a.part[p], b.part[p]);
#else
  UWSIM_UNROLLED a.part[p] = __builtin_ia32_minps(a.part[p], b.part[p]);
#endif
  return a;
}
UWSIM_LANES Float max(Float a, Float b) {
  constexpr int kParts = Float::kParts;
#if defined(__AVX512F__)
  UWSIM_UNROLLED a.part[p] = __builtin_ia32_maxps512_mask(a.part[p], b.part[p], a.part[p], -1, 4);
#elif defined(__AVX2__)
  UWSIM_UNROLLED a.part[p] = __builtin_ia32_maxps256(a.part[p], b.part[p]);
#else
  UWSIM_UNROLLED a.part[p] = __builtin_ia32_maxps(a.part[p], b.part[p]);
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
  UWSIM_UNROLLED x.part[p] = __builtin_ia32_sqrtps512_mask(x.part[p], x.part[p], -1, 4);
#elif defined(__AVX2__)
  UWSIM_UNROLLED x.part[p] = __builtin_ia32_sqrtps256(x.part[p]);
#else
  UWSIM_UNROLLED x.part[p] = __builtin_ia32_sqrtps(x.part[p]);
#endif
  return x;
}
UWSIM_LANES Float mix(Float a, Float b, Float share) { return a + (b - a) * share; }
UWSIM_LANES Float smooth(Float x) {
  const Float t = clamp(x, 0, 1);
  return t * t * (3 - 2 * t);
}

/// A whole number of at most 22 bits and the numbers' bits that end in it: adding 1.5 2^23 leaves no bits for
/// fractions.
struct Rounded {
  Float whole;
  Int bits;
};
UWSIM_LANES Rounded rounded(Float x) {
  const Float shifted = x + 0x1.8p23f;
  return {shifted - 0x1.8p23f, bits_as<std::int32_t>(shifted)};
}

/// e^x for x below 88, 0 below -87: 2^k times a polynomial of least relative error on [-1/2, 1/2], in x / ln 2;
/// relative error below 2e-7 + 1.2e-7 |x|.
UWSIM_LANES Float exponential(Float x) {
  const Float y = max(x, splat(-87)) * 1.44269504f;
  const Rounded k = rounded(y);
  const Float r = y - k.whole;
  const Float p = 1 + r * (0.693147f + r * (0.24022242f + r * (0.055507336f + r * (9.671513e-3f + r * 1.326473e-3f))));
  const Float value = bits_as<float>(bits_as<std::int32_t>(p) + (k.bits << 23));
  return select(x < -87, Float{}, value);
}

/// Natural logarithm of a positive normal number, within 2e-7 absolute and relative: 2 artanh of (m - 1) / (m + 1).
UWSIM_LANES Float logarithm(Float x) {
  const Int bits = bits_as<std::int32_t>(x);
  Int exponent = (bits >> 23) - 127;
  Float m = bits_as<float>((bits & 0x007fffff) | 0x3f800000);
  const Int high = m > 1.41421356f;
  m = select(high, m * 0.5f, m);
  exponent -= high;
  const Float s = (m - 1) / (m + 1), z = s * s;
  const Float series = 2 * s * (1 + z * (1.0f / 3 + z * (0.2f + z * (1.0f / 7 + z * (1.0f / 9)))));
  return series + to_float(exponent) * 0.69314718f;
}

/// Sine within 1e-6, for |x| up to some 1e4: of what whole half turns leave, which turn its sign.
UWSIM_LANES Float sine(Float x) {
  const Rounded halves = rounded(x * 0.318309886f);
  const Float r = x - halves.whole * 3.140625f - halves.whole * 9.67653590e-4f, z = r * r;
  const Float upright =
      r * (1 + z * (-1.0f / 6 + z * (1.0f / 120 + z * (-1.0f / 5040 + z * (1.0f / 362880 - z * (1.0f / 39916800))))));
  return bits_as<float>(bits_as<std::int32_t>(upright) ^ (halves.bits << 31));
}
UWSIM_LANES Float cosine(Float x) { return sine(x + 1.57079633f); }

/// Sine and cosine of a number of turns, within 1e-6, for up to some 1e4.
struct Turn {
  Float sine, cosine;
};
UWSIM_LANES Turn turned(Float turns) {
  const Rounded halves = rounded(turns * 2);
  const Float r = (turns - halves.whole * 0.5f) * 6.28318531f, z = r * r;
  const Float s =
      r * (1 + z * (-1.0f / 6 + z * (1.0f / 120 + z * (-1.0f / 5040 + z * (1.0f / 362880 - z * (1.0f / 39916800))))));
  const Float c = 1 + z * (-0.5f + z * (1.0f / 24 + z * (-1.0f / 720 + z * (1.0f / 40320 - z * (1.0f / 3628800)))));
  const Int sign = halves.bits << 31;
  return {bits_as<float>(bits_as<std::int32_t>(s) ^ sign), bits_as<float>(bits_as<std::int32_t>(c) ^ sign)};
}

/// Angle of the direction (x, y), y >= 0, in [0, pi] within 2e-6: turned to within an eighth of pi of the x axis, then
/// the arc tangent's series.
UWSIM_LANES Float angle_of(Float x, Float y) {
  const Int back = x < 0;
  const Float along = select(back, y, x), across = select(back, -x, y);
  const Int steep = across > along * 2.41421356f, middle = across > along * 0.41421356f;
  const Float part = select(steep, -along, select(middle, across - along, across));
  const Float whole = select(steep, across, select(middle, across + along, along));
  const Float base = select(steep, splat(1.57079633f), select(middle, splat(0.785398163f), Float{}));
  const Float r = part / max(whole, splat(1e-30f)), z = r * r;
  const Float series = r + r * z * (-0.333329491f + z * (0.199777106f + z * (-0.138776856f + z * 8.05374449e-2f)));
  return select(back, splat(1.57079633f), Float{}) + base + series;
}

struct Vector {
  Float x, y, z;
};
UWSIM_LANES Vector operator+(Vector a, Vector b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
UWSIM_LANES Vector operator-(Vector a, Vector b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
UWSIM_LANES Vector operator*(Vector a, Float s) { return {a.x * s, a.y * s, a.z * s}; }
UWSIM_LANES Vector operator*(Vector a, Vector b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
UWSIM_LANES Float dot(Vector a, Vector b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
UWSIM_LANES Vector unit(Vector a) { return a * (1 / square_root(max(dot(a, a), splat(1e-30f)))); }
UWSIM_LANES Vector select(Int mask, Vector a, Vector b) {
  return {select(mask, a.x, b.x), select(mask, a.y, b.y), select(mask, a.z, b.z)};
}
UWSIM_LANES Vector spread(const float* xyz) { return {splat(xyz[0]), splat(xyz[1]), splat(xyz[2])}; }
UWSIM_LANES Vector exponential(Vector a) { return {exponential(a.x), exponential(a.y), exponential(a.z)}; }

/// A whole number as a number in [0, 1), by a mixer of the PCG family (Jarzynski and Olano 2020, "Hash Functions for
/// GPU Rendering"): looks random, for textures; noise draws from Philox.
UWSIM_LANES Unsigned hash(Unsigned x) {
  const Unsigned state = x * 747796405u + 2891336453u;
  const Unsigned word = ((state >> 13) ^ state) * 277803737u;
  return (word >> 16) ^ word;
}
UWSIM_LANES Float hash_unit(Unsigned x) { return to_float(bits_as<std::int32_t>(hash(x) >> 8)) * 0x1p-24f; }

}  // namespace
}  // namespace uwsim::camera
