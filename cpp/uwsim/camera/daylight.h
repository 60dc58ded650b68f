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
/// deg for solar elevations h down to -6 deg (assumed). No clouds and no ozone. The air mass is that of pvlib 0.16; tau
/// of molecules is within 0.2 % of Bodhaine et al. 1999 (J. Atmos. Ocean. Tech. 16:1854). The sum on level ground is
/// within 7 % of SPCTRAL2 (Bird 1984, Solar Energy 32:461) for a sun 30 deg high or higher, but at 600 nm, where ozone
/// absorbs, 16 % brighter for a sun at 15 deg and 34 % at 8 deg (`uwsim validate peers`).
struct Daylight {
  Eigen::Vector3d to_sun_world;  ///< unit
  Bands beam;                    ///< irradiance by the sun on a surface facing it
  Bands sky;                     ///< irradiance by the sky on level ground
};
Daylight daylight(const Sun& sun);

/// Daylight just below a flat water surface. The beam is refracted (Snell) and loses the reflected part (Fresnel); 6.6
/// % of the sky's light is reflected, the integral of Fresnel's reflectance over a sky of even radiance (Jerlov 1976,
/// "Marine Optics", ch. 5).
struct DaylightBelow {
  Eigen::Vector3d to_sun_world;  ///< unit, after refraction
  Bands beam_level;              ///< irradiance by the beam on a level surface
  Bands sky_level;               ///< irradiance by the sky on a level surface
};
DaylightBelow daylight_below(const Daylight& above, double refractive_index);

}  // namespace uwsim
