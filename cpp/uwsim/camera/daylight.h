#pragma once

#include "uwsim/camera/water_optics.h"

namespace uwsim {

/// Where the sun stands.
struct Sun {
  double elevation_rad = 0.8;
  double azimuth_rad = 0;  ///< towards it, from east, counter-clockwise
};

/// Clear-sky daylight, in units of the sun's irradiance outside the air in each band, which the camera's white balance
/// takes for white; 1 is taken as 1e5 lx where lamps are compared with it (assumed: a full summer's sun is about that).
/// Direct: exp(-tau m), air mass m after Kasten and Young 1989 (Appl. Opt. 28:4735), tau of molecules after Hansen and
/// Travis 1974 (Space Sci. Rev. 16:527) plus 0.08 (550 nm / lambda)^1.3 of haze (assumed). Diffuse: half of what the
/// beam loses reaches the ground (assumed: single scattering), and twilight of 0.004 sin(h + 6 deg) / sin 6 deg for
/// suns down to -6 deg (assumed). No clouds. Formulae from memory of their papers.
struct Daylight {
  Eigen::Vector3d to_sun_world;  ///< unit
  Bands beam;                    ///< of the sun on a surface that faces it
  Bands sky;                     ///< of the sky on level ground
};
Daylight daylight(const Sun& sun);

/// The same just below a flat water surface. The beam is bent (Snell) and loses what is reflected (Fresnel); 6.6 % of
/// the sky's light is reflected (Jerlov 1976, "Marine Optics", as commonly quoted: assumed).
struct DaylightBelow {
  Eigen::Vector3d to_sun_world;  ///< unit, after refraction
  Bands beam_level;              ///< of the beam on a level surface
  Bands sky_level;               ///< likewise
};
DaylightBelow daylight_below(const Daylight& above, double refractive_index);

}  // namespace uwsim
