#pragma once

#include "uwsim/camera/kernels/block_lanes.h"
#include "uwsim/camera/kernels/view.h"

/// Scattering in the water: phase functions, daylight at depth, and the backscatter of daylight. Included only by the
/// kernels.
namespace uwsim::camera {
namespace {

constexpr float kPi = 3.14159265f;

// Asymmetry of particles for daylight. Single scattering with the asymmetry of real particles (about 0.9) would make
// the water around the camera ten times too dark, because daylight is scattered many times. A value of 0.5 results in a
// horizontal radiance of about 0.04 of the downwelling irradiance in turbid water, as in radiance distributions
// measured in lakes and seas: assumed, but of the right order of magnitude.
constexpr float kDaylightAsymmetry = 0.5f;
// Asymmetry of particles for lamps: near the camera, their light is scattered once (Petzold 1972, represented by g =
// 0.9; assumed).
constexpr float kLampAsymmetry = 0.9f;

/// Phase function of Henyey and Greenstein 1941, [1/sr].
UWSIM_LANES Float henyey_greenstein_phase(Float cosine, float g) {
  const Float side = 1 + g * g - 2 * g * cosine;
  return splat((1 - g * g) / (4 * kPi)) / (side * square_root(max(side, splat(1e-6f))));
}

/// Phase function of molecules (Rayleigh), [1/sr].
UWSIM_LANES Float rayleigh_phase(Float cosine) { return (3 / (16 * kPi)) * (1 + cosine * cosine); }

/// Light that water scatters towards the eye per unit of irradiance, [1/(m sr)]. `g`: one of the asymmetries above.
UWSIM_LANES Vector scattering(const View& view, Float cosine, float g) {
  const Float particles = henyey_greenstein_phase(cosine, g), molecules = rayleigh_phase(cosine);
  return broadcast(view.particle_b) * particles + broadcast(view.molecule_b) * molecules;
}

/// Irradiance on a level surface at a depth: `total` decreases by Kd; `beam`, the sun's part, also loses the light
/// scattered out of it.
struct DaylightAtDepth {
  Vector total, beam;
};
UWSIM_LANES DaylightAtDepth daylight_at_depth(const View& view, Float depth) {
  const Float d = max(depth, Float{});
  DaylightAtDepth day;
  day.total = broadcast(view.total_level) * exponential(broadcast(view.kd) * (-d));
  day.beam = broadcast(view.beam_level) * exponential(broadcast(view.kb) * (-d));
  return day;
}

/// Daylight that `length` of water scatters into a ray, attenuated on its way to the eye, in closed form. Daylight
/// varies as exp(-K depth) along the ray, so the backscatter is J / k (1 - exp(-k length)) with k = c - K
/// sin(elevation); it saturates, at J / c for a level ray. Split into the part due to the sun's beam, which shafts
/// modulate, and the rest. `day`: where the ray starts.
UWSIM_LANES void daylight_backscatter(const View& view, const DaylightAtDepth& day, Vector direction, Float length,
                                      Vector& diffuse, Vector& beam) {
  const Vector c = broadcast(view.c), kd = broadcast(view.kd), kb = broadcast(view.kb);
  const auto gain_over = [&](Float c1, Float k1) {
    const Float rate = max(c1 - k1 * direction.z, 0.05f * c1 + 1e-6f);
    return (1 - exponential(-rate * length)) / rate;
  };
  const Vector total = {gain_over(c.x, kd.x), gain_over(c.y, kd.y), gain_over(c.z, kd.z)};
  const Vector direct = {gain_over(c.x, kb.x), gain_over(c.y, kb.y), gain_over(c.z, kb.z)};
  const Vector from_above = scattering(view, direction.z, kDaylightAsymmetry);
  const Vector from_sun = scattering(view, dot(direction, broadcast(view.to_sun_in_water)), kDaylightAsymmetry);
  beam = day.beam * direct * from_sun * splat(1 / view.to_sun_in_water[2]);
  diffuse = (day.total * total - day.beam * direct) * from_above;
  diffuse = {max(diffuse.x, Float{}), max(diffuse.y, Float{}), max(diffuse.z, Float{})};
}

}  // namespace
}  // namespace uwsim::camera
