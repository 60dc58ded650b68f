#pragma once

#include "uwsim/estimation/filter_state.h"

namespace uwsim {

/// The head of the waves' pressure at a depth gauge [m]: b of swinging_noise.h, about a period of 5 s, of unknown
/// strength. Its spectrum is zero at zero frequency, so that waves are not confused with depth, and broad, since the
/// filter does not receive the sea's spectrum: seas with periods from 3 to 12 s lie in its band.
///
/// The variance follows the innovations: it is the mean of E[b^2], given the readings, over the last 10 s (the step of
/// Shumway and Stoffer 1982, J. Time Series Analysis 3:253, for a variance by expectation maximisation, but with
/// filtered moments and a fading memory).
class WavePressure {
 public:
  static constexpr int kErrors = 2;  ///< a, then b

  /// `first_std_m`: the variance before the first reading. `least_std_m`: waves are never assumed to be smaller.
  WavePressure(double first_std_m, double least_std_m) : first_std_m_(first_std_m), least_std_m_(least_std_m) {}

  BiasModel first() const { return {.turn_on_std = first_std_m_}; }
  double first_std_m() const { return first_std_m_; }
  /// Advances a and b, which are the errors from index `first` on, and their variance over dt.
  void age(FilterState& state, int first, double& own_variance, double dt_s) const;

 private:
  double first_std_m_, least_std_m_;
};

}  // namespace uwsim
