#include "uwsim/core/random_path.h"

#include <cmath>

namespace uwsim {

RandomPath RandomPath::gauss_markov(const RandomStream& stream, std::uint32_t index, double std,
                                    double correlation_steps) {
  RandomPath path(stream, index);
  for (int level = 0; level < kLevels; ++level) {
    const double u = std::ldexp(1.0, level) / correlation_steps;
    path.levels_[static_cast<std::size_t>(level)].pull = 0.5 / std::cosh(u);  // 0 where cosh overflows
    path.levels_[static_cast<std::size_t>(level)].spread = std * std::sqrt(std::tanh(u));
  }
  const double kept = std::exp(-std::ldexp(1.0, kLevels) / correlation_steps);
  path.first_ = std * stream.normal(0, index);
  path.last_ = kept * path.first_ + std * std::sqrt(-std::expm1(-2 * std::ldexp(1.0, kLevels) / correlation_steps)) *
                                        stream.normal(std::uint64_t{1} << kLevels, index);
  return path;
}

RandomPath RandomPath::random_walk(const RandomStream& stream, std::uint32_t index, double std_step) {
  RandomPath path(stream, index);
  for (int level = 0; level < kLevels; ++level) {
    path.levels_[static_cast<std::size_t>(level)].pull = 0.5;
    path.levels_[static_cast<std::size_t>(level)].spread = std_step * std::sqrt(0.5 * std::ldexp(1.0, level));
  }
  path.last_ = std_step * std::ldexp(1.0, kLevels / 2) * stream.normal(std::uint64_t{1} << kLevels, index);
  return path;
}

double RandomPath::at(std::uint64_t step) {
  step &= (std::uint64_t{1} << kLevels) - 1;
  if (step == 0) return first_;
  std::uint64_t low = 0;
  double at_low = first_, at_high = last_;
  for (int level = kLevels - 1;; --level) {
    Level& here = levels_[static_cast<std::size_t>(level)];
    const std::uint64_t middle = low + (std::uint64_t{1} << level);
    if (here.middle != middle) {
      here.middle = middle;
      here.value = here.pull * (at_low + at_high) + here.spread * stream_.normal(middle, index_);
    }
    if (step == middle) return here.value;
    if (step < middle) {
      at_high = here.value;
    } else {
      low = middle;
      at_low = here.value;
    }
  }
}

}  // namespace uwsim
