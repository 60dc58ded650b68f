#pragma once

#include "uwsim/core/double_lanes.h"

// Sine, cosine and exponential of several values at a time, within 2e-16 of the largest value, with the same bits on
// every instruction set. Taylor series after argument reduction (Muller 2016, Elementary Functions, ch. 3 and 11).
namespace uwsim {
namespace {

/// Returns the nearest integer, for |x| < 2^51, and stores its lowest bits in two's complement.
inline DoubleLanes nearest_whole(DoubleLanes x, IndexLanes& bits) {
  constexpr double kShift = 6755399441055744.0;  // 1.5 * 2^52: adding it rounds to integers
  const DoubleLanes shifted = x + kShift;
  std::memcpy(&bits, &shifted, sizeof bits);
  return shifted - kShift;
}

/// Sine and cosine for |x| <= 1e6. Pi / 2 is split into three parts; the first two have so few bits that their
/// multiples are exact (Cody and Waite 1980).
inline void sine_and_cosine(DoubleLanes x, DoubleLanes& sine, DoubleLanes& cosine) {
  constexpr double kHigh = 0x1.921fb544p+0, kMiddle = 0x1.0b4611a6p-34, kLow = 0x1.3198a2e037073p-69;
  IndexLanes quarter;
  const DoubleLanes turns = nearest_whole(x * 0x1.45f306dc9c883p-1, quarter);
  const DoubleLanes r = ((x - turns * kHigh) - turns * kMiddle) - turns * kLow, r2 = r * r;
  constexpr double kSine[] = {-1.0 / 6,        1.0 / 120,          -1.0 / 5040,           1.0 / 362880,
                              -1.0 / 39916800, 1.0 / 6227020800.0, -1.0 / 1307674368000.0};
  constexpr double kCosine[] = {1.0 / 24,        -1.0 / 720,           1.0 / 40320,           -1.0 / 3628800,
                                1.0 / 479001600, -1.0 / 87178291200.0, 1.0 / 20922789888000.0};
  DoubleLanes s = DoubleLanes{} + kSine[6], c = DoubleLanes{} + kCosine[6];
  for (int n = 5; n >= 0; --n) {
    s = s * r2 + kSine[n];
    c = c * r2 + kCosine[n];
  }
  s = r + r * (r2 * s);
  c = 1 - (0.5 * r2 - r2 * (r2 * c));
  const IndexLanes odd = (quarter & 1) != 0, sine_negative = (quarter & 2) != 0,
                   cosine_negative = ((quarter + 1) & 2) != 0;
  const DoubleLanes sine_size = odd ? c : s, cosine_size = odd ? s : c;
  sine = sine_negative ? -sine_size : sine_size;
  cosine = cosine_negative ? -cosine_size : cosine_size;
}

/// exp(x) and exp(-x) for x <= 0. Values below -700 are treated as -700. The even and odd terms of the series are
/// summed separately, which gives both exponentials and halves the chain of dependent operations.
inline void exponentials(DoubleLanes x, DoubleLanes& exp_x, DoubleLanes& exp_minus_x) {
  constexpr double kHigh = 0x1.62e42fee00000p-1, kLow = 0x1.a39ef35793c76p-33;  // of ln 2
  x = x > -700.0 ? x : DoubleLanes{} - 700.0;
  IndexLanes power;
  const DoubleLanes doublings = nearest_whole(x * 0x1.71547652b82fep+0, power);
  const DoubleLanes r = (x - doublings * kHigh) - doublings * kLow, r2 = r * r;
  constexpr double kEven[] = {1.0 / 2, 1.0 / 24, 1.0 / 720, 1.0 / 40320, 1.0 / 3628800, 1.0 / 479001600.0};
  constexpr double kOdd[] = {1.0 / 6, 1.0 / 120, 1.0 / 5040, 1.0 / 362880, 1.0 / 39916800, 1.0 / 6227020800.0};
  DoubleLanes even = DoubleLanes{} + kEven[5], odd = DoubleLanes{} + kOdd[5];
  for (int n = 4; n >= 0; --n) {
    even = even * r2 + kEven[n];
    odd = odd * r2 + kOdd[n];
  }
  even = 1 + even * r2;
  odd = r + r * (odd * r2);
  const IndexLanes exponent = (power + 1023) << 52, opposite = (1023 - power) << 52;
  DoubleLanes scale, opposite_scale;
  std::memcpy(&scale, &exponent, sizeof scale);
  std::memcpy(&opposite_scale, &opposite, sizeof opposite_scale);
  exp_x = (even + odd) * scale;
  exp_minus_x = (even - odd) * opposite_scale;
}

}  // namespace
}  // namespace uwsim
