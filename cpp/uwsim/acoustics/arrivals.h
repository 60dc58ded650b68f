#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "uwsim/acoustics/absorption_column.h"
#include "uwsim/acoustics/modem/boundary_loss.h"
#include "uwsim/acoustics/ray_fan.h"
#include "uwsim/acoustics/sound_speed_profile.h"

namespace uwsim {

/// The losses of sound in addition to its spreading.
struct SoundLosses {
  double frequency_hz;
  FluidBottom bottom;
  double surface_rms_m = 0;                      ///< rms height of the waves
  const AbsorptionColumn* absorption = nullptr;  ///< at the sound's frequency; null: no absorption
};

/// Limits on which arrivals are kept.
struct ArrivalLimits {
  double within_db = 40;    ///< arrivals weaker than the strongest by more than this are dropped
  std::size_t most = 500;   ///< largest number of arrivals; the strongest are kept
  int most_bounces = 1000;  ///< sum over both boundaries
};

/// Sound that arrives along one ray. Dips are below the horizontal, in the direction of travel.
struct Arrival {
  int surface_bounces = 0;
  int bottom_bounces = 0;
  int turns = 0;  ///< turning points
  double launch_dip_rad = 0;
  double arrival_dip_rad = 0;
  double time_s = 0;
  double length_m = 0;
  double level_db = 0;   ///< relative to the source's level at 1 m
  double phase_rad = 0;  ///< in (-pi, pi]: sound sent as cos(w t) arrives as cos(w (t - time_s) - phase_rad)
  /// Bounces and turning points divide the ray into legs. These are the horizontal lengths of the first leg, of each
  /// leg in between and of the last leg, the least and the greatest depth of the ray, and the grazing angles there,
  /// which are 0 where the ray turns.
  double first_m = 0, crossing_m = 0, last_m = 0;
  double top_m = 0, bottom_m = 0, top_grazing_rad = 0, bottom_grazing_rad = 0;
  double widening_m2_s = 0;  ///< dx / dp: change of the distance with the Snell invariant; 0 at a caustic

  int legs() const { return surface_bounces + bottom_bounces + turns + 1; }
};

/// Returns the arrivals of all rays between two points in layered water between a flat surface and a flat bottom,
/// sorted by time, with any number of bounces and turning points, up to 1000 in all. Rays with the same first direction
/// and the same number of turning points and bounces form a family, whose range is a piecewise smooth function of the
/// launch angle; every crossing of the receiver's range is solved for (RayFan has the closed forms).
///
/// Level: the intensity of the ray tube is I = cos(launch) / (r |dr / dlaunch| sin(arrival)), times the ratio of
/// the speeds of sound for pressure (Jensen, Kuperman, Porter and Schmidt 2011, "Computational Ocean Acoustics", ch.
/// 3.3, not consulted), reduced by absorption along the ray, Rayleigh reflection at the bottom (bottom_reflection) and
/// the coherent loss of the rough surface (surface_loss_db). At a caustic the tube's width vanishes: the intensity is
/// limited to (k L / 2)^(1/3) times that of spherical spreading over the ray's length L, with k = 2 pi f / c, which is
/// the focusing given by the Airy function at a smooth caustic with d2r / dlaunch2 = L. Closer to the source than 1 m,
/// the level at 1 m is returned. Times and levels are within 10 us and 1 dB of BELLHOP's (`uwsim validate sound`).
///
/// Phase, for exp(-i w t): pi for each reflection at the surface, the phase of the Rayleigh coefficient for each
/// reflection at the bottom, and -pi/2 for each caustic that the ray has touched.
///
/// High-frequency limit: no diffraction, no sound behind a caustic, no waves along the bottom. In a profile with linear
/// layers, rays that graze the boundary between two layers are weaker or stronger than in a smooth profile. Throws
/// InvalidValue for ends outside the water.
std::vector<Arrival> arrivals(const SoundSpeedProfile& profile, const RayEnds& ends, const SoundLosses& losses,
                              const ArrivalLimits& limits = {});

/// As above, but writes to `found`. Allocates memory only if there are more layers or arrivals than in any earlier
/// call.
void find_arrivals(const SoundSpeedProfile& profile, const RayEnds& ends, const SoundLosses& losses,
                   const ArrivalLimits& limits, std::vector<Arrival>& found);

/// Returns the first arrival that has not bounced, with the level of its ray tube, or nullopt in a shadow zone of such
/// rays. Allocates memory only if there are more layers than in any earlier call.
std::optional<Arrival> direct_arrival(const SoundSpeedProfile& profile, const RayEnds& ends);

}  // namespace uwsim
