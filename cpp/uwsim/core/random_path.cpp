#include "uwsim/core/random_path.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace uwsim {

RandomPath RandomPath::gauss_markov(const RandomStream& stream, std::uint32_t index, double std,
                                    double correlation_steps) {
  RandomPath path(stream, index);
  for (int level = 0; level < kLevels; ++level) {
    const double u = std::ldexp(1.0, level) / correlation_steps;
    path.levels_[static_cast<std::size_t>(level)].mean_weight = 0.5 / std::cosh(u);  // 0 where cosh overflows
    path.levels_[static_cast<std::size_t>(level)].std = std * std::sqrt(std::tanh(u));
  }
  const double correlation = std::exp(-std::ldexp(1.0, kLevels) / correlation_steps);
  path.first_ = std * stream.normal(0, index);
  path.last_ =
      correlation * path.first_ + std * std::sqrt(-std::expm1(-2 * std::ldexp(1.0, kLevels) / correlation_steps)) *
                                      stream.normal(std::uint64_t{1} << kLevels, index);
  return path;
}

RandomPath RandomPath::random_walk(const RandomStream& stream, std::uint32_t index, double std_step) {
  RandomPath path(stream, index);
  for (int level = 0; level < kLevels; ++level) {
    path.levels_[static_cast<std::size_t>(level)].mean_weight = 0.5;
    path.levels_[static_cast<std::size_t>(level)].std = std_step * std::sqrt(0.5 * std::ldexp(1.0, level));
  }
  path.last_ = std_step * std::ldexp(1.0, kLevels / 2) * stream.normal(std::uint64_t{1} << kLevels, index);
  return path;
}

double RandomPath::at(std::uint64_t step) {
  step &= (std::uint64_t{1} << kLevels) - 1;
  if (step == 0) return first_;
  // Down to the highest bit in which the step differs from the previous one, both descents have the same midpoints
  const int parting = static_cast<int>(std::bit_width(step ^ before_)) - 1;
  const int shared =
      std::max({parting, std::countr_zero(step), std::countr_zero(before_ | std::uint64_t{1} << (kLevels - 1))});
  before_ = step;
  std::uint64_t low = step >> (shared + 1) << (shared + 1);
  double at_low = end(low), at_high = end(low + (std::uint64_t{2} << shared));
  for (int level = shared;; --level) {
    Level& here = levels_[static_cast<std::size_t>(level)];
    const std::uint64_t midpoint = low + (std::uint64_t{1} << level);
    if (here.midpoint != midpoint) {
      here.midpoint = midpoint;
      here.value = here.mean_weight * (at_low + at_high) + here.std * stream_.normal(midpoint, index_);
    }
    if (step == midpoint) return here.value;
    if (step < midpoint) {
      at_high = here.value;
    } else {
      low = midpoint;
      at_low = here.value;
    }
  }
}

}  // namespace uwsim
