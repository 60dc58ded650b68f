#pragma once

#include <vector>

#include "uwsim/estimation/filter_state.h"

namespace uwsim {

/// The errors of a depth gauge that are the water's. The gauge's reading divided by the surface's density and gravity
/// is level - z + column:
///
/// - level: the height of the still surface above z = 0 [m], a tide of unknown phase: a of swinging_noise.h about the
///   period of M2, 12.42 h. Its band holds tides from M4 to K1. Two errors, a and b.
/// - column: the weight of the water above the gauge beyond that of as much surface water [m of it]. It is a share of
///   the depth, which changes with it: that of a column of independent layers. Once the gauge has moved by dD at depth
///   D, exp(-kLayer dD / D^2) of the share's variance is that of before, the rest is that of other water. A gauge that
///   keeps its depth keeps its column. The state is not the share, whose product with the depth would bend the filter.
///
/// Neither is observed by the gauge alone, which measures their sum with the depth.
class WaterAbove {
 public:
  static constexpr int kErrors = 3;  ///< level, its companion, column

  /// Standard deviations before the first reading, of the column as a share of the depth. 0: no error, ever.
  WaterAbove(double level_std_m, double column_std) : level_std_m_(level_std_m), column_std_(column_std) {}

  std::vector<BiasModel> first() const;
  double level_std_m() const { return level_std_m_; }
  double column_std() const { return column_std_; }
  /// Sets the column's variance at the first reading, which shows its depth.
  void begin(FilterState& state, int first, double depth_m) const;
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
