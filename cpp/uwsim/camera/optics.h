#pragma once

#include "uwsim/camera/daylight.h"
#include "uwsim/camera/water_optics.h"

namespace uwsim {

/// All that determines the light in a place: its water, the sun, the wind that ruffles the surface, and particles.
struct Optics {
  WaterOptics water;
  Sun sun;
  double wind_m_s = 3;
  double wind_towards_rad = 0;
  double particles_per_m3 = 60;  ///< large enough to be seen one by one: assumed

  /// Throws InvalidValue that names the field. The sun and the wind are checked where they are used.
  void check() const;
};

}  // namespace uwsim
