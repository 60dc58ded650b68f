#pragma once

#include "uwsim/core/float_lane_functions.h"

/// The random draws of core/random.h, sixteen at a time. Included only by kernels.
namespace uwsim {
namespace {

struct PhiloxWords {
  Unsigned word[4];
};

/// Philox4x32-10 as in core/random.h, for sixteen counters at once, with the same words. Values are kept in the low
/// halves of wide lanes; the high halves accumulate garbage, which is never read.
UWSIM_LANES PhiloxWords philox(Wide c0, Wide c1, Wide c2, Wide c3, std::uint64_t key) {
  auto k0 = static_cast<std::uint32_t>(key), k1 = static_cast<std::uint32_t>(key >> 32);
  for (int round = 0; round < 10; ++round) {
    const Wide p0 = times_low(c0, 0xD2511F53u), p1 = times_low(c2, 0xCD9E8D57u);
    c0 = (p1 >> 32) ^ c1 ^ k0;
    c1 = p1;
    c2 = (p0 >> 32) ^ c3 ^ k1;
    c3 = p0;
    k0 += 0x9E3779B9u;
    k1 += 0xBB67AE85u;
  }
  const auto low = [](Wide c) { return narrowed<std::uint32_t>(c); };
  return {{low(c0), low(c1), low(c2), low(c3)}};
}
UWSIM_LANES Float open_unit(Unsigned word) { return (to_float(bits_as<std::int32_t>(word >> 8)) + 0.5f) * 0x1p-24f; }

}  // namespace
}  // namespace uwsim
