#pragma once

#include "uwsim/camera/kernels/block_weights.h"
#include "uwsim/camera/kernels/daylight.h"

/// Lamps: their light on surfaces and their backscatter in the water. Included only by the kernels.
namespace uwsim::camera {
namespace {

constexpr int kBackscatterSamples = 4;

/// A lamp's light on surfaces, to be tested by a shadow ray if it matters: intensity / distance^2, attenuated by the
/// water in between.
void shade_lamp(const View& view, int index, Block& block) {
  const SpotLight& lamp = view.lamps[index];
  const Vector point = load(block.point), normal = load(block.normal);
  const Vector to_lamp = broadcast(lamp.position) - point;
  const Float square = max(dot(to_lamp, to_lamp), splat(1e-4f));
  const Float distance = square_root(square);
  const Vector direction = to_lamp * (1 / distance);
  const Float cone = -dot(direction, broadcast(lamp.axis));
  const Int lit = load(block.lit.at) & (cone > lamp.cos_outer);
  store(block.needs_shadow_ray.at, lit);
  if (!any(lit)) return;
  const Float spot = smoothstep((cone - lamp.cos_outer) * (1 / (lamp.cos_inner - lamp.cos_outer)));
  const Float cosine = max(dot(normal, direction), Float{});
  Vector light = broadcast(lamp.intensity) * (spot * cosine / square);
  if (view.has_attenuation) light = light * transmission(view.c, distance);
  store(block.to_light, direction);
  store(block.light_distance.at, distance - 0.02f);
  const Int in_water = load(block.in_water.at);
  add_or_test(view, lit, reflected_from(view, block, normal, direction, in_water) * light, block);
}

/// The part of a ray, from `begin` to `end`, inside the lamp's outer cone: from..to along the ray, empty if from >= to.
UWSIM_LANES void cone_crossing(const SpotLight& lamp, Vector direction, Float begin, Float end, Float& from,
                               Float& to) {
  const Vector m = broadcast(lamp.position) * splat(-1), axis = broadcast(lamp.axis);
  const float cos2 = lamp.cos_outer * lamp.cos_outer;
  const Float da = dot(direction, axis), ma = dot(m, axis);
  const Float a = da * da - cos2, b = da * ma - cos2 * dot(direction, m), c = ma * ma - cos2 * dot(m, m);
  const Float inside = b * b - a * c;
  const Int misses = inside < 0;
  const Float root = square_root(max(inside, Float{}));
  const Float per_a = 1 / select(abs(a) < 1e-6f, splat(1e-6f), a);
  const Float t1 = (-b - root) * per_a, t2 = (-b + root) * per_a;
  const Float low = min(t1, t2), high = max(t1, t2);
  // A ray steeper than the cone's side is inside between the roots; a shallower one is inside beyond the last root or
  // before the first.
  const Int crosses = a < 0;
  from = select(crosses, low, select(da > 0, high, splat(0)));
  to = select(crosses, high, select(da > 0, end, low));
  from = max(from, begin);
  to = min(to, end);
  const Float middle = 0.5f * (from + to);
  const Int behind = ma + da * middle < 0;
  const Int empty = (crosses & misses) | behind;
  to = select(empty, from, to);
}

/// A lamp as seen from points along a ray: its soft edge, 0 at the outer cone and 1 at the inner one, is
/// ahead c + along s + edge, for the sine s and the cosine c of lamp_scattering.
struct LampAlongRay {
  Float nearest, apart, ahead, along;  ///< the ray's nearest point to the lamp, and its distance from the lamp
  float edge;
};

/// The lamp's light that the water at one point scatters towards the eye, attenuated on both paths, divided by
/// intensity / apart. `s`, `c`: sine and cosine of the angle at the lamp between the ray's nearest point and this one;
/// -s is also the cosine of the scattering angle.
UWSIM_LANES Vector lamp_scattering(const View& view, const LampAlongRay& lamp, Float s, Float c) {
  constexpr float g = kLampAsymmetry;
  const Float spot = smoothstep(lamp.ahead * c + lamp.along * s + lamp.edge);
  // Computes henyey_greenstein_phase(-s, g) = (1 - g^2) / (4 pi) / cube and path = nearest + apart (1 + s) / c with a
  // single division.
  const Float side = 1 + g * g + 2 * g * s, cube = side * square_root(side), per = 1 / (cube * c);
  const Float path = lamp.nearest + lamp.apart * ((1 + s) * (cube * per));
  const Float particles = spot * (c * per) * ((1 - g * g) / (4 * kPi)), molecules = spot * rayleigh_phase(s);
  const Vector light = broadcast(view.particle_b) * particles + broadcast(view.molecule_b) * molecules;
  return view.has_attenuation ? light * transmission(view.c, path) : light;
}

/// Single scattering of the lamp's light into the ray, sampled at points that are evenly spaced in the angle at the
/// lamp (Kulla and Fajardo 2012, "Importance sampling techniques for path tracing in participating media"): dt /
/// distance^2 = d angle / closest distance, so the peak near the lamp needs no additional samples. Shadows are ignored.
/// The light is that from the water between two distances along the ray.
template <int kSamples>
UWSIM_LANES Vector lamp_backscatter(const View& view, int index, Vector direction, Float begin, Float end, Int active) {
  const SpotLight& lamp = view.lamps[index];
  Float from, to;
  cone_crossing(lamp, direction, begin, end, from, to);
  const Int crosses = active & (to > from);
  if (!any(crosses)) return zero();
  const Vector lamp_at = broadcast(lamp.position), axis = broadcast(lamp.axis);
  const Float nearest = dot(lamp_at, direction);
  const Float apart = square_root(max(dot(lamp_at, lamp_at) - nearest * nearest, splat(1e-4f)));
  const float per_edge = 1 / (lamp.cos_inner - lamp.cos_outer);
  const Float per_apart = 1 / apart, cosine = dot(direction, axis);
  const LampAlongRay along = {nearest, apart, (cosine * nearest - dot(lamp_at, axis)) * per_apart * per_edge,
                              cosine * per_edge, -lamp.cos_outer * per_edge};
  const Float first = from - nearest, last = to - nearest;
  const Float step = angle_of(apart * apart + first * last, apart * (last - first)) * (1.0f / kSamples);
  const Float half = 0.5f * step, z = half * half;  // half is at most pi / 4, so series suffice
  const Float half_s = half * (1 + z * (-1.0f / 6 + z * (1.0f / 120 - z * (1.0f / 5040))));
  const Float half_c = 1 + z * (-0.5f + z * (1.0f / 24 - z * (1.0f / 720)));
  const Float step_s = 2 * half_s * half_c, step_c = 1 - 2 * half_s * half_s;
  const Float per = 1 / square_root(apart * apart + first * first);
  Float s = (first * half_c + apart * half_s) * per, c = (apart * half_c - first * half_s) * per;
  Vector sum = zero();
  for (int k = 0; k < kSamples; ++k) {
    sum = sum + lamp_scattering(view, along, s, max(c, splat(1e-4f)));
    const Float turned = s * step_c + c * step_s;
    c = c * step_c - s * step_s;
    s = turned;
  }
  return select(crosses, sum * broadcast(lamp.intensity) * (step * per_apart), zero());
}

/// The backscatter of all lamps. Along rays that nothing ends early, it varies slowly over the picture and is
/// interpolated between blocks (lamp_glow.h). What lies beyond the end of other rays is subtracted; since most of the
/// light comes from near the lamps, one sample is enough for that.
void add_glow(const View& view, int left, int top, Block& block) {
  const LampGlow& glow = view.glow;
  const Vector direction = load(block.direction);
  const Int active = load(block.active.at) & load(block.in_water.at);
  const Float reach = load(block.reach.at), farthest = splat(glow.reach_m);
  const BlockNeighbours at(view, left, top);
  Vector added = zero();
  if (glow.is_smooth != nullptr && glow.is_smooth[at.rows[1] + at.columns[1]] && !any(active & (reach < glow.near_m))) {
    static constexpr BlockWeights kWeights = block_weights(kGlowPixel);
    added = {interpolate_blocks(kWeights, at, glow.bands[0]), interpolate_blocks(kWeights, at, glow.bands[1]),
             interpolate_blocks(kWeights, at, glow.bands[2])};
    if (any(active & (reach < farthest))) {
      for (int k = 0; k < view.lamp_count; ++k) {
        added = added - lamp_backscatter<1>(view, k, direction, reach, farthest, active);
      }
      added = {max(added.x, Float{}), max(added.y, Float{}), max(added.z, Float{})};
    }
  } else {
    for (int k = 0; k < view.lamp_count; ++k) {
      added = added + lamp_backscatter<kBackscatterSamples>(view, k, direction, Float{}, min(reach, farthest), active);
    }
  }
  const Vector light = load(block.radiance);
  store(block.radiance, select(active, light + added, light));
}

}  // namespace
}  // namespace uwsim::camera
