#pragma once

#include <vector>

#include "uwsim/estimation/filter_state.h"

namespace uwsim {

/// The errors of a depth gauge that are the water's. The gauge's reading divided by the surface's density and gravity
/// is (1 + column) (level - z):
///
/// - level: the height of the still surface above z = 0 [m], a tide of unknown phase: a of swinging_noise.h about the
///   period of M2, 12.42 h. Its band holds tides from M4 to K1. Two errors, a and b.
/// - column: how much heavier the water above the gauge is than the same column of surface water, relative. It is that
///   of a column of independent layers: once the gauge has moved by dD at depth D, the share exp(-kLayer dD / D^2) of
///   its variance is that of before, the rest is that of other water. A gauge that keeps its depth keeps its column.
///
/// Neither is observed by the gauge alone, which measures their sum with the depth.
class WaterAbove {
 public:
  static constexpr int kErrors = 3;  ///< level, its companion, column

  /// Standard deviations before the first reading. 0: it is known, and errs by nothing, ever.
  WaterAbove(double level_std_m, double column_std) : level_std_m_(level_std_m), column_std_(column_std) {}

  std::vector<BiasModel> first() const;
  double level_std_m() const { return level_std_m_; }
  double column_std() const { return column_std_; }
  /// Advances the errors, which begin at index `first`, over dt, while the depth [m] changes at `sinking_m_s`.
  /// `level_variance`: of the level, which may be larger than it was expected to be.
  void age(FilterState& state, int first, double level_variance, double depth_m, double sinking_m_s, double dt_s) const;
  /// Lets a discrepancy [m] at this depth be the water's: of the level up to `most_level_m`, of the column as far as
  /// that is plausible.
  void doubt(FilterState& state, int first, double depth_m, double residual_m, double most_level_m) const;

 private:
  double level_std_m_, column_std_;
};

}  // namespace uwsim
