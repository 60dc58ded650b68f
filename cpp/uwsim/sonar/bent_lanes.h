#pragma once

#include <cstddef>
#include <cstdint>

#include "uwsim/core/float_lanes.h"

// Doubles of some bent rays side by side. In an anonymous namespace, because files for several instruction sets include
// it.
namespace uwsim {
namespace {

// Some rays side by side take two of the CPU's registers: with one, each operation waits for the one before it. (Of
// wider vectors GCC 12 compares and selects the values one by one, with branches.)
constexpr int kParts = 2;
constexpr int kEach = kNativeBytes / static_cast<int>(sizeof(double));
constexpr std::size_t kSome = kParts * kEach;
using Part = Native<double>::Part;
using MaskPart = decltype(Part{} < Part{});

/// Truth values of some rays.
struct Mask {
  MaskPart part[kParts];

#define UWSIM_OPERATOR(op)                               \
  friend UWSIM_INLINE Mask operator op(Mask a, Mask b) { \
    UWSIM_UNROLLED a.part[p] = a.part[p] op b.part[p];   \
    return a;                                            \
  }
  UWSIM_OPERATOR(&)
  UWSIM_OPERATOR(|)
#undef UWSIM_OPERATOR
};

/// Values of some rays.
struct Reals {
  Part part[kParts];

  UWSIM_INLINE Reals() { UWSIM_UNROLLED part[p] = Part{}; }
  UWSIM_INLINE Reals(double value) {  // NOLINT(google-explicit-constructor)
    UWSIM_UNROLLED part[p] = value - Part{};
  }
  explicit UWSIM_INLINE Reals(const double* from) {
    UWSIM_UNROLLED part[p] = reinterpret_cast<const Native<double>::InMemory*>(from)[p];
  }
  UWSIM_INLINE void store(double* to) const {
    UWSIM_UNROLLED reinterpret_cast<Native<double>::InMemory*>(to)[p] = part[p];
  }

#define UWSIM_OPERATOR(op)                                  \
  friend UWSIM_INLINE Reals operator op(Reals a, Reals b) { \
    UWSIM_UNROLLED a.part[p] = a.part[p] op b.part[p];      \
    return a;                                               \
  }
#define UWSIM_COMPARISON(op)                               \
  friend UWSIM_INLINE Mask operator op(Reals a, Reals b) { \
    Mask mask;                                             \
    UWSIM_UNROLLED mask.part[p] = a.part[p] op b.part[p];  \
    return mask;                                           \
  }
  UWSIM_OPERATOR(+)
  UWSIM_OPERATOR(-)
  UWSIM_OPERATOR(*)
  UWSIM_OPERATOR(/)
  UWSIM_COMPARISON(<)
  UWSIM_COMPARISON(>)
  UWSIM_COMPARISON(<=)
  UWSIM_COMPARISON(==)
#undef UWSIM_OPERATOR
#undef UWSIM_COMPARISON
};

UWSIM_INLINE Mask inverse(Mask mask) {
  UWSIM_UNROLLED mask.part[p] = ~mask.part[p];
  return mask;
}
UWSIM_INLINE Reals select(Mask mask, Reals yes, Reals no) {
  UWSIM_UNROLLED yes.part[p] = mask.part[p] ? yes.part[p] : no.part[p];
  return yes;
}
/// One bit for each truth value.
UWSIM_INLINE unsigned bits_of(MaskPart part) {
#if defined(__AVX512F__)
  return _mm512_test_epi64_mask((__m512i)part, (__m512i)part);
#elif defined(__AVX2__)
  return static_cast<unsigned>(_mm256_movemask_pd((__m256d)part));
#elif defined(__SSE2__)
  return static_cast<unsigned>(_mm_movemask_pd((__m128d)part));
#else
  unsigned bits = 0;
  for (int k = 0; k < kEach; ++k) bits |= (part[k] != 0 ? 1u : 0u) << k;
  return bits;
#endif
}
UWSIM_INLINE unsigned bits_of(Mask mask) {
  unsigned bits = 0;
  UWSIM_UNROLLED bits |= bits_of(mask.part[p]) << (p * kEach);
  return bits;
}
UWSIM_INLINE bool any(Mask mask) {
  MaskPart found = mask.part[0];
  UWSIM_UNROLLED found |= mask.part[p];
  return bits_of(found) != 0;
}
/// Calls a function with the number of each truth value that is true.
template <typename Function>
UWSIM_INLINE void for_each(Mask mask, const Function& function) {
  for (unsigned left = bits_of(mask); left != 0; left &= left - 1) {
    function(static_cast<std::size_t>(__builtin_ctz(left)));
  }
}
UWSIM_INLINE bool all(Mask mask) { return !any(inverse(mask)); }
UWSIM_INLINE Reals smaller(Reals a, Reals b) { return select(b < a, b, a); }
UWSIM_INLINE Reals larger(Reals a, Reals b) { return select(a < b, b, a); }
UWSIM_INLINE Reals square_root(Reals x) {
#if defined(__AVX512F__)
  UWSIM_UNROLLED x.part[p] = _mm512_sqrt_pd(x.part[p]);
#elif defined(__AVX2__)
  UWSIM_UNROLLED x.part[p] = _mm256_sqrt_pd(x.part[p]);
#elif defined(__SSE2__)
  UWSIM_UNROLLED x.part[p] = _mm_sqrt_pd(x.part[p]);
#else
  UWSIM_UNROLLED for (int k = 0; k < kEach; ++k) x.part[p][k] = __builtin_sqrt(x.part[p][k]);
#endif
  return x;
}
constexpr long long kSign = static_cast<long long>(1ULL << 63);
UWSIM_INLINE Reals magnitude(Reals x) {
  UWSIM_UNROLLED x.part[p] = (Part)((MaskPart)x.part[p] & ~kSign);
  return x;
}
UWSIM_INLINE Reals with_sign(Reals x, Reals sign) {
  UWSIM_UNROLLED x.part[p] = (Part)(((MaskPart)x.part[p] & ~kSign) | ((MaskPart)sign.part[p] & kSign));
  return x;
}
// As many 32-bit values as a register holds doubles, anywhere in memory.
using Ints = std::int32_t __attribute__((vector_size(kNativeBytes / 2)));
using Floats = float __attribute__((vector_size(kNativeBytes / 2)));
using IntsInMemory = std::int32_t __attribute__((vector_size(kNativeBytes / 2), aligned(4), may_alias));
using FloatsInMemory = float __attribute__((vector_size(kNativeBytes / 2), aligned(4), may_alias));

UWSIM_INLINE Mask load_mask(const std::int32_t* from) {
  const auto* const ints = reinterpret_cast<const IntsInMemory*>(from);
  Mask mask;
  UWSIM_UNROLLED mask.part[p] = __builtin_convertvector(ints[p], MaskPart);
  return mask;
}
UWSIM_INLINE void store_mask(std::int32_t* to, Mask mask) {
  auto* const ints = reinterpret_cast<IntsInMemory*>(to);
  UWSIM_UNROLLED ints[p] = __builtin_convertvector(mask.part[p], Ints);
}
UWSIM_INLINE Reals load_floats(const float* from) {
  const auto* const floats = reinterpret_cast<const FloatsInMemory*>(from);
  Reals value;
  UWSIM_UNROLLED value.part[p] = __builtin_convertvector(floats[p], Part);
  return value;
}
UWSIM_INLINE void store_floats(float* to, Reals value) {
  auto* const floats = reinterpret_cast<FloatsInMemory*>(to);
  UWSIM_UNROLLED floats[p] = __builtin_convertvector(value.part[p], Floats);
}
struct Vectors {
  Reals x, y, z;

  friend UWSIM_INLINE Vectors operator-(const Vectors& a, const Vectors& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
  }
  friend UWSIM_INLINE Vectors operator+(const Vectors& a, const Vectors& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
  }
  friend UWSIM_INLINE Vectors operator*(Reals s, const Vectors& a) { return {s * a.x, s * a.y, s * a.z}; }
  friend UWSIM_INLINE Vectors operator/(const Vectors& a, Reals s) { return {a.x / s, a.y / s, a.z / s}; }
};
UWSIM_INLINE Reals dot(const Vectors& a, const Vectors& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
UWSIM_INLINE Vectors select(Mask mask, const Vectors& a, const Vectors& b) {
  return {select(mask, a.x, b.x), select(mask, a.y, b.y), select(mask, a.z, b.z)};
}

}  // namespace
}  // namespace uwsim
