#pragma once

#include <limits>

#include "uwsim/camera/daylight.h"
#include "uwsim/camera/water_optics.h"

namespace uwsim {

/// Everything that determines the light in an area: its water, the sun, the wind that ruffles the surface, and
/// particles.
struct Optics {
  WaterOptics water;
  Sun sun;
  double wind_m_s = 3;
  double wind_towards_rad = 0;
  double particles_per_m3 = 60;  ///< large enough to be visible individually; assumed
  double turbulence_k = 2;       ///< standard deviation of temperature in turbulent eddies; assumed, strong mixing
  double fetch_m = std::numeric_limits<double>::infinity();  ///< of the water over which the wind has blown

  /// Throws InvalidValue naming the field. The sun and the wind are checked where they are used.
  void check() const;
};

/// The standard deviation of the angle by which turbulence displaces the scene, along one axis of the picture: sqrt(2
/// sqrt(pi) / 3 L / l) dn/dT T' (geometrical optics with a Gaussian correlation of the index, Chernov 1960, "Wave
/// Propagation in a Random Medium", ch. 2; the factor of a third applies to rays from a point, Tatarskii 1971). |dn/dT|
/// = 1e-4 per K (Quan and Fry 1995, Appl. Opt. 34:3477, at 10 to 20 degrees C). It is assumed that eddies have a size
/// of l = 5 cm and that every ray bends as it would over a path of L = 5 m. Valid for weak focusing and displacements
/// up to a few mrad.
double turbulence_bend_rad(double turbulence_k);

}  // namespace uwsim
