#pragma once

#include <vector>

#include "uwsim/world/harmonics.h"

namespace uwsim {

/// One constituent of a tide: amplitude cos(speed t - phase).
struct TidalConstituent {
  double amplitude_m = 0;
  double speed_rad_s = 0;
  double phase_rad = 0;
};

/// The height of the still surface above z = 0, the same in the whole world: a sum of constituents (Doodson 1921).
class Tide {
 public:
  /// Throws InvalidValue naming water.tide.
  explicit Tide(const std::vector<TidalConstituent>& constituents);

  double height_m(double time_s) const { return heights_.at(time_s).value(0); }
  /// Bound of the height's magnitude [m].
  double bound_m() const { return heights_.bound(); }

 private:
  HarmonicSum heights_;
};

}  // namespace uwsim
