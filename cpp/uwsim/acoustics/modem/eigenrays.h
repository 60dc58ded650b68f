#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "uwsim/acoustics/sound_speed_profile.h"

namespace uwsim {

/// A ray of sound that connects two points.
struct Eigenray {
  int surface_bounces = 0;
  int bottom_bounces = 0;
  double launch_dip_rad = 0;   ///< below the horizontal, at its start
  double arrival_dip_rad = 0;  ///< below the horizontal, at its end, in the direction of travel
  double time_s = 0;
  double length_m = 0;
  double surface_grazing_rad = 0;    ///< angle between ray and surface at the reflection
  double bottom_grazing_rad = 0;     ///< angle between ray and bottom at the reflection
  int legs = 0;                      ///< number of legs, separated by reflections
  std::array<double, 3> across_m{};  ///< horizontal length of each leg
};

/// The ends of eigenrays. Depths [m] are in [0, bottom_m]; bottom_m may be infinite, which disables reflections from
/// the bottom.
struct RayEnds {
  double from_depth_m;
  double to_depth_m;
  double across_m;
  double bottom_m;
};

/// Returns the rays between two points through a layered profile, between a flat surface and a flat bottom: direct
/// rays, and rays reflected by the surface, by the bottom, or by each of them once. By Snell's law, cos(dip) / c = p,
/// the horizontal length of a leg that does not turn is the integral of p c / sqrt(1 - p^2 c^2) over depth, which has a
/// closed form in each layer (as in SoundPath) and is solved for p. If no such leg reaches far enough, the direct ray
/// turns at the depth where c = 1 / p. If no turning ray reaches the receiver either, it is in a shadow zone and no
/// direct ray is returned. High-frequency limit: no diffraction, no focusing. If the profile has several extremes,
/// there may be several rays of one kind; only the first one found on each side is returned. The rays are sorted by
/// travel time. Throws InvalidValue for ends outside the water.
std::vector<Eigenray> eigenrays(const SoundSpeedProfile& profile, const RayEnds& ends, bool with_bounces = true);

/// Returns only the direct ray, or nullopt in a shadow zone. Does not allocate memory.
std::optional<Eigenray> direct_ray(const SoundSpeedProfile& profile, const RayEnds& ends);

}  // namespace uwsim
