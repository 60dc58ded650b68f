#pragma once

#include <array>
#include <cstdint>

#include "uwsim/core/random.h"

namespace uwsim {

/// A correlated random process x(0), x(1), ... of which any step can be asked for, in any order, and always gives the
/// same value: Levy's construction. The ends x(0) and x(2^40) are drawn first, then the middle of each interval given
/// its two ends, down to the step asked for. Each step is the middle of exactly one interval, so its number keys its
/// draw. Exact in distribution, not an approximation; the last way down is kept, so that steps read in order cost two
/// draws each. Steps beyond 2^40 (174 years of 5 ms) start again from 0.
class RandomPath {
 public:
  /// Stationary first-order Gauss-Markov (Ornstein-Uhlenbeck) process: x(k) ~ N(0, std^2), correlation
  /// exp(-|j-k| / correlation_steps). Middle of an interval of ends a, b and half length h: mean (a + b) / (2 cosh u),
  /// variance std^2 tanh u, u = h / correlation_steps.
  static RandomPath gauss_markov(const RandomStream& stream, std::uint32_t index, double std, double correlation_steps);

  /// Random walk from x(0) = 0: increments N(0, std_step^2). Middle: mean (a + b) / 2, variance std_step^2 h / 2.
  static RandomPath random_walk(const RandomStream& stream, std::uint32_t index, double std_step);

  double at(std::uint64_t step);

 private:
  static constexpr int kLevels = 40;
  struct Level {
    double pull = 0;           ///< the middle's mean is this times the sum of the ends
    double spread = 0;         ///< standard deviation about it
    std::uint64_t middle = 0;  ///< where the last way down passed; 0 when it has not
    double value = 0;          ///< x(middle)
  };

  RandomPath(const RandomStream& stream, std::uint32_t index) : stream_(stream), index_(index) {}

  RandomStream stream_;
  std::uint32_t index_;
  double first_ = 0, last_ = 0;
  std::array<Level, kLevels> levels_;  ///< levels_[l] halves intervals of 2^(l+1) steps
};

}  // namespace uwsim
