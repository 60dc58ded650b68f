#pragma once

#include "uwsim/core/float_lanes.h"

/// Functions and vectors of sixteen lanes. The functions are polynomials, so that all builds produce the same bits;
/// their comments state the errors. Included only by the kernels.
namespace uwsim {
namespace {

UWSIM_LANES Float mix(Float a, Float b, Float share) { return a + (b - a) * share; }
UWSIM_LANES Float smoothstep(Float x) {
  const Float t = clamp(x, 0, 1);
  return t * t * (3 - 2 * t);
}

/// x rounded to an integer of at most 22 bits, as a number and in the lowest bits of `bits`: adding 1.5 * 2^23 leaves
/// no bits for fractions.
struct Rounded {
  Float whole;
  Int bits;
};
UWSIM_LANES Rounded rounded(Float x) {
  const Float shifted = x + 0x1.8p23f;
  return {shifted - 0x1.8p23f, bits_as<std::int32_t>(shifted)};
}

/// e^x for x below 88, 0 below -87: 2^k times a minimax polynomial in the remainder of x / ln 2 on [-1/2, 1/2]; the
/// relative error is below 2e-7 + 1.2e-7 |x|.
UWSIM_LANES Float exponential(Float x) {
  const Float y = max(x, splat(-87)) * 1.44269504f;
  const Rounded k = rounded(y);
  const Float r = y - k.whole;
  const Float p = 1 + r * (0.693147f + r * (0.24022242f + r * (0.055507336f + r * (9.671513e-3f + r * 1.326473e-3f))));
  const Float value = bits_as<float>(bits_as<std::int32_t>(p) + (k.bits << 23));
  return select(x < -87, Float{}, value);
}

/// Natural logarithm of a positive normal number, within 2e-7 absolute and relative: 2 artanh((m - 1) / (m + 1)).
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

/// Sine within 1e-6, for |x| up to about 1e4: a series in the remainder after subtracting whole half turns, which flip
/// the sign.
UWSIM_LANES Float sine(Float x) {
  const Rounded halves = rounded(x * 0.318309886f);
  const Float r = x - halves.whole * 3.140625f - halves.whole * 9.67653590e-4f, z = r * r;
  const Float upright =
      r * (1 + z * (-1.0f / 6 + z * (1.0f / 120 + z * (-1.0f / 5040 + z * (1.0f / 362880 - z * (1.0f / 39916800))))));
  return bits_as<float>(bits_as<std::int32_t>(upright) ^ (halves.bits << 31));
}
UWSIM_LANES Float cosine(Float x) { return sine(x + 1.57079633f); }

/// Sine and cosine of an angle in turns, within 1e-6, for up to about 1e4 turns.
struct SineCosine {
  Float sine, cosine;
};
UWSIM_LANES SineCosine sine_cosine_of_turns(Float turns) {
  const Rounded halves = rounded(turns * 2);
  const Float r = (turns - halves.whole * 0.5f) * 6.28318531f, z = r * r;
  const Float s =
      r * (1 + z * (-1.0f / 6 + z * (1.0f / 120 + z * (-1.0f / 5040 + z * (1.0f / 362880 - z * (1.0f / 39916800))))));
  const Float c = 1 + z * (-0.5f + z * (1.0f / 24 + z * (-1.0f / 720 + z * (1.0f / 40320 - z * (1.0f / 3628800)))));
  const Int sign = halves.bits << 31;
  return {bits_as<float>(bits_as<std::int32_t>(s) ^ sign), bits_as<float>(bits_as<std::int32_t>(c) ^ sign)};
}

/// Angle of the direction (x, y), y >= 0, in [0, pi], within 2e-6: the direction is rotated to within pi / 8 of the x
/// axis, where the arctangent series is used.
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
UWSIM_LANES Vector cross(Vector a, Vector b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
UWSIM_LANES Vector unit(Vector a) { return a * (1 / square_root(max(dot(a, a), splat(1e-30f)))); }
UWSIM_LANES Vector select(Int mask, Vector a, Vector b) {
  return {select(mask, a.x, b.x), select(mask, a.y, b.y), select(mask, a.z, b.z)};
}
UWSIM_LANES Vector broadcast(const float* xyz) { return {splat(xyz[0]), splat(xyz[1]), splat(xyz[2])}; }
UWSIM_LANES Vector exponential(Vector a) { return {exponential(a.x), exponential(a.y), exponential(a.z)}; }

/// An integer hash, using a mixer of the PCG family (Jarzynski and Olano 2020, "Hash Functions for GPU Rendering"). It
/// is random enough for textures; noise uses Philox.
UWSIM_LANES Unsigned hash(Unsigned x) {
  const Unsigned state = x * 747796405u + 2891336453u;
  const Unsigned word = ((state >> 13) ^ state) * 277803737u;
  return (word >> 16) ^ word;
}
/// The hash as a number in [0, 1).
UWSIM_LANES Float hash_unit(Unsigned x) { return to_float(bits_as<std::int32_t>(hash(x) >> 8)) * 0x1p-24f; }

}  // namespace
}  // namespace uwsim
