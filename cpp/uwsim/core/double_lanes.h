#pragma once

#include <cstdint>
#include <cstring>

// Eight doubles at a time, for kernels that are compiled once for each instruction set, hence the anonymous namespace.
// Comparisons produce masks, which select with ?:.
namespace uwsim {
namespace {

using DoubleLanes = double __attribute__((vector_size(64)));
using IndexLanes = long long __attribute__((vector_size(64)));

[[maybe_unused]] inline DoubleLanes load_lanes(const double* numbers) {
  DoubleLanes out;
  std::memcpy(&out, numbers, sizeof out);
  return out;
}

[[maybe_unused]] inline void store_lanes(DoubleLanes lanes, double* numbers) {
  std::memcpy(numbers, &lanes, sizeof lanes);
}

/// Stores 1 for true, 0 for false.
[[maybe_unused]] inline void store_flags(IndexLanes mask, std::uint8_t* flags) {
  using Flags = signed char __attribute__((vector_size(8)));
  const Flags out = -__builtin_convertvector(mask, Flags);
  std::memcpy(flags, &out, sizeof out);
}

[[maybe_unused]] inline double sum_of_lanes(DoubleLanes s) {
  return ((s[0] + s[1]) + (s[2] + s[3])) + ((s[4] + s[5]) + (s[6] + s[7]));
}

/// Selects lanes from both arguments, numbered 0 to 15, in the given order.
template <int... kFrom>
DoubleLanes mixed_lanes(DoubleLanes a, DoubleLanes b) {
  return __builtin_shufflevector(a, b, kFrom...);
}

/// Stores eight points, x y z for each, from lanes of x, y and z.
[[maybe_unused]] inline void store_points(DoubleLanes x, DoubleLanes y, DoubleLanes z, double* points) {
  const DoubleLanes first = mixed_lanes<0, 8, 0, 1, 9, 0, 2, 10>(x, y);
  const DoubleLanes second = mixed_lanes<0, 3, 11, 0, 4, 12, 0, 5>(x, y);
  const DoubleLanes third = mixed_lanes<13, 0, 6, 14, 0, 7, 15, 0>(x, y);
  store_lanes(mixed_lanes<0, 1, 8, 3, 4, 9, 6, 7>(first, z), points);
  store_lanes(mixed_lanes<10, 1, 2, 11, 4, 5, 12, 7>(second, z), points + 8);
  store_lanes(mixed_lanes<0, 13, 2, 3, 14, 5, 6, 15>(third, z), points + 16);
}

/// Loads eight points; the inverse of store_points.
[[maybe_unused]] inline void load_points(const double* points, DoubleLanes& x, DoubleLanes& y, DoubleLanes& z) {
  const DoubleLanes a = load_lanes(points), b = load_lanes(points + 8), c = load_lanes(points + 16);
  x = mixed_lanes<0, 1, 2, 3, 4, 5, 10, 13>(mixed_lanes<0, 3, 6, 9, 12, 15, 0, 0>(a, b), c);
  y = mixed_lanes<0, 1, 2, 3, 4, 8, 11, 14>(mixed_lanes<1, 4, 7, 10, 13, 0, 0, 0>(a, b), c);
  z = mixed_lanes<0, 1, 2, 3, 4, 9, 12, 15>(mixed_lanes<2, 5, 8, 11, 14, 0, 0, 0>(a, b), c);
}

}  // namespace
}  // namespace uwsim
