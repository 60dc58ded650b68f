#pragma once

#include "uwsim/camera/water_optics.h"

namespace uwsim {

/// The position of the sun.
struct Sun {
  double elevation_rad = 0.8;
  double azimuth_rad = 0;  ///< direction towards it, from east, counter-clockwise
};

/// Clear-sky daylight. In each band, the unit is the sun's irradiance outside the atmosphere, which the camera's white
/// balance renders as white; for comparison with lamps, 1 is 1e5 lx (assumed: about full summer sun). Direct beam:
/// exp(-tau m), with air mass m after Kasten and Young 1989 (Appl. Opt. 28:4735), and tau of molecules after Hansen and
/// Travis 1974 (Space Sci. Rev. 16:527) plus 0.08 (550 nm / lambda)^1.3 for haze (assumed). Diffuse: half of the light
/// lost from the beam reaches the ground (assumed: single scattering), plus twilight of 0.004 sin(h + 6 deg) / sin 6
/// deg for solar elevations h down to -6 deg (assumed). No clouds. The formulas are quoted from memory of these papers.
struct Daylight {
  Eigen::Vector3d to_sun_world;  ///< unit
  Bands beam;                    ///< irradiance by the sun on a surface facing it
  Bands sky;                     ///< irradiance by the sky on level ground
};
Daylight daylight(const Sun& sun);

/// Daylight just below a flat water surface. The beam is refracted (Snell) and loses the reflected part (Fresnel); 6.6
/// % of the sky's light is reflected (Jerlov 1976, "Marine Optics", as commonly quoted; assumed).
struct DaylightBelow {
  Eigen::Vector3d to_sun_world;  ///< unit, after refraction
  Bands beam_level;              ///< irradiance by the beam on a level surface
  Bands sky_level;               ///< irradiance by the sky on a level surface
};
DaylightBelow daylight_below(const Daylight& above, double refractive_index);

}  // namespace uwsim
