#pragma once

#include "uwsim/camera/water_optics.h"
#include "uwsim/core/pose.h"

namespace uwsim {

/// A spot lamp: uniform within the inner angle, dark beyond the outer angle, smooth in between.
struct SpotLamp {
  Pose world_from_lamp;  ///< the lamp shines along x
  double flux_lm = 10'000;
  double half_angle_rad = 0.6;   ///< the outer angle
  double soft_share = 0.4;       ///< fraction of the half angle over which the light falls off
  Bands colour = Bands::Ones();  ///< relative to the white of daylight

  /// Throws InvalidValue naming the field.
  void check() const;
};

}  // namespace uwsim
