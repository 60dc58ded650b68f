#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include "uwsim/core/random.h"

namespace uwsim {

/// A correlated random process x(0), x(1), ... whose steps may be read in any order and always have the same values
/// (Levy's construction). The ends x(0) and x(2^40) are drawn first. Then intervals are halved down to the requested
/// step, and each midpoint is drawn from its distribution given the two ends. Each step is the midpoint of exactly one
/// interval, so the step's number keys its draw. The distribution is exact, not approximate. The midpoints of the last
/// descent are cached, and the next descent begins at the level where the two diverge, so reading steps in order costs
/// about one draw and two levels per step. Steps beyond 2^40 (174 years at 5 ms) start again from 0.
class RandomPath {
 public:
  /// Stationary first-order Gauss-Markov (Ornstein-Uhlenbeck) process: x(k) ~ N(0, std^2), with the correlation
  /// exp(-|j-k| / correlation_steps) between x(j) and x(k). The midpoint of an interval with ends a, b and half length
  /// h has the mean (a + b) / (2 cosh u) and the variance std^2 tanh u, where u = h / correlation_steps.
  static RandomPath gauss_markov(const RandomStream& stream, std::uint32_t index, double std, double correlation_steps);

  /// Random walk from x(0) = 0 with increments N(0, std_step^2). In the notation above, a midpoint has the mean (a + b)
  /// / 2 and the variance std_step^2 h / 2.
  static RandomPath random_walk(const RandomStream& stream, std::uint32_t index, double std_step);

  double at(std::uint64_t step);

 private:
  static constexpr int kLevels = 40;
  struct Level {
    double mean_weight = 0;      ///< a midpoint's mean is this times the sum of the ends
    double std = 0;              ///< standard deviation about it
    std::uint64_t midpoint = 0;  ///< visited by the last descent; 0 if there was none
    double value = 0;            ///< x(midpoint)
  };

  RandomPath(const RandomStream& stream, std::uint32_t index) : stream_(stream), index_(index) {}

  /// The value at an end of an interval on the way to `before_`.
  double end(std::uint64_t step) const {
    if (step == 0) return first_;
    const int level = std::countr_zero(step);
    return level == kLevels ? last_ : levels_[static_cast<std::size_t>(level)].value;
  }

  RandomStream stream_;
  std::uint32_t index_;
  std::uint64_t before_ = 0;  ///< the last step that was read; 0 if there was none
  double first_ = 0, last_ = 0;
  std::array<Level, kLevels> levels_;  ///< levels_[l] halves intervals of 2^(l+1) steps
};

}  // namespace uwsim
