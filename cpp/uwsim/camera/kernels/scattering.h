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

/// Fraction of light that is left after `length` [m], exp(-per_m length), for a length >= 0: 2^k times a minimax
/// polynomial in the remainder on [-1/2, 1/2]. The relative error is below 4e-6 + 1.2e-7 per_m length; it is exactly 1
/// at 0, and 1e-38 where the true fraction is even smaller.
UWSIM_LANES Float transmission(Float per_m, Float length) {
  const Float y = max(length * (per_m * -1.44269504f), splat(-126));
  const Rounded k = rounded(y);
  const Float r = y - k.whole;
  const Float p = 1 + r * (0.69312433f + r * (0.24024145f + r * (0.05590597f + r * 9.58105e-3f)));
  return bits_as<float>(bits_as<std::int32_t>(p) + (k.bits << 23));
}
UWSIM_LANES Vector transmission(const float* per_m, Float length) {
  return {transmission(splat(per_m[0]), length), transmission(splat(per_m[1]), length),
          transmission(splat(per_m[2]), length)};
}

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
  day.total = broadcast(view.total_level) * transmission(view.kd, d);
  day.beam = broadcast(view.beam_level) * transmission(view.kb, d);
  return day;
}

/// The rate [1/m] at which the backscatter along a ray saturates; `up`: the ray's direction.z.
constexpr float kSlowest = 0.05f;  // at least this fraction of c
UWSIM_LANES Float backscatter_rate(Float c, Float k, Float up) { return max(c - k * up, kSlowest * c + 1e-6f); }

/// Daylight that `length` of water scatters into a ray, attenuated on its way to the eye, in closed form. Daylight
/// varies as exp(-K depth) along the ray, so the backscatter is J / k (1 - exp(-k length)) with k = c - K
/// sin(elevation); it saturates, at J / c for a level ray. Split into the part due to the sun's beam, which shafts
/// modulate, and the rest. `day`: where the ray starts. `is_endless`: for lengths at which it is saturated.
UWSIM_LANES void daylight_backscatter(const View& view, const DaylightAtDepth& day, Vector direction, Float length,
                                      bool is_endless, Vector& diffuse, Vector& beam) {
  const Vector c = broadcast(view.c), kd = broadcast(view.kd), kb = broadcast(view.kb);
  const auto gain_over = [&](Float c1, Float k1) {
    const Float rate = backscatter_rate(c1, k1, direction.z);
    return (is_endless ? splat(1) : 1 - transmission(rate, length)) / rate;
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
