#pragma once

#include "uwsim/camera/kernels/daylight.h"

/// Lamps: their light on surfaces and their backscatter in the water. Included only by the kernels.
namespace uwsim::camera {
namespace {

constexpr int kBackscatterSamples = 4;

/// A lamp's light on surfaces, to be tested by a shadow ray: intensity / distance^2, attenuated by the water in
/// between.
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
  if (view.has_attenuation) light = light * exponential(broadcast(view.c) * (-distance));
  light = reflected_per_irradiance(block) * light;
  store(block.unshadowed, light);
  store(block.to_light, direction);
  store(block.light_distance.at, distance - 0.02f);
  const Vector so_far = load(block.radiance);
  const Float lamp_light = light.x + light.y + light.z;
  store(block.needs_shadow_ray.at,
        lit & (lamp_light > kShadowRayThreshold * (so_far.x + so_far.y + so_far.z)) & (lamp_light > 1e-9f));
}

/// The part of a ray inside the lamp's outer cone: from..to along the ray, empty if from >= to.
UWSIM_LANES void cone_crossing(const SpotLight& lamp, Vector direction, Float end, Float& from, Float& to) {
  const Vector m = broadcast(lamp.position) * splat(-1), axis = broadcast(lamp.axis);
  const float cos2 = lamp.cos_outer * lamp.cos_outer;
  const Float da = dot(direction, axis), ma = dot(m, axis);
  const Float a = da * da - cos2, b = da * ma - cos2 * dot(direction, m), c = ma * ma - cos2 * dot(m, m);
  const Float inside = b * b - a * c;
  const Int misses = inside < 0;
  const Float root = square_root(max(inside, Float{}));
  const Float safe = select(abs(a) < 1e-6f, splat(1e-6f), a);
  const Float t1 = (-b - root) / safe, t2 = (-b + root) / safe;
  const Float low = min(t1, t2), high = max(t1, t2);
  // A ray steeper than the cone's side is inside between the roots; a shallower one is inside beyond the last root or
  // before the first.
  const Int crosses = a < 0;
  from = select(crosses, low, select(da > 0, high, splat(0)));
  to = select(crosses, high, select(da > 0, end, low));
  from = max(from, Float{});
  to = min(to, end);
  const Float middle = 0.5f * (from + to);
  const Int behind = ma + da * middle < 0;
  const Int empty = (crosses & misses) | behind;
  to = select(empty, from, to);
}

/// The lamp's light that the water at one point scatters towards the eye, attenuated on both paths, divided by
/// intensity / apart. `s`, `c`: sine and cosine of the angle at the lamp between the ray's nearest point and this one;
/// -s is also the cosine of the scattering angle. `ahead`, `along`: the cosine to the lamp's axis is ahead c + along s.
UWSIM_LANES Vector lamp_scattering(const View& view, const SpotLight& lamp, Float s, Float c, Float ahead, Float along,
                                   Float nearest, Float apart) {
  constexpr float g = kLampAsymmetry;
  const Float spot = smoothstep((ahead * c + along * s - lamp.cos_outer) * (1 / (lamp.cos_inner - lamp.cos_outer)));
  // Computes henyey_greenstein_phase(-s, g) = (1 - g^2) / (4 pi) / cube and path = nearest + apart (1 + s) / c with a
  // single division.
  const Float side = 1 + g * g + 2 * g * s, cube = side * square_root(side), per = 1 / (cube * c);
  const Float path = nearest + apart * ((1 + s) * (cube * per));
  const Float particles = spot * (c * per) * ((1 - g * g) / (4 * kPi)), molecules = spot * rayleigh_phase(s);
  const Vector light = broadcast(view.particle_b) * particles + broadcast(view.molecule_b) * molecules;
  return view.has_attenuation ? light * exponential(broadcast(view.c) * -path) : light;
}

/// Single scattering of the lamp's light into the ray, sampled at points that are evenly spaced in the angle at the
/// lamp (Kulla and Fajardo 2012, "Importance sampling techniques for path tracing in participating media"): dt /
/// distance^2 = d angle / closest distance, so the peak near the lamp needs no additional samples. Shadows are ignored.
void add_lamp_backscatter(const View& view, int index, Block& block) {
  const SpotLight& lamp = view.lamps[index];
  const Vector direction = load(block.direction);
  const Int active = load(block.active.at) & load(block.in_water.at);
  // Light from beyond eight attenuation lengths is not noticeable.
  const Float end = min(load(block.reach.at), splat(8 / view.c[1]));
  Float from, to;
  cone_crossing(lamp, direction, end, from, to);
  const Int crosses = active & (to > from);
  if (!any(crosses)) return;
  const Vector lamp_at = broadcast(lamp.position), axis = broadcast(lamp.axis);
  const Float nearest = dot(lamp_at, direction);
  const Float apart = square_root(max(dot(lamp_at, lamp_at) - nearest * nearest, splat(1e-4f)));
  const Float along = dot(direction, axis), ahead = (along * nearest - dot(lamp_at, axis)) / apart;
  const Float first = from - nearest, last = to - nearest;
  const Float step = angle_of(apart * apart + first * last, apart * (last - first)) * (1.0f / kBackscatterSamples);
  const Float half = 0.5f * step, z = half * half;  // half is at most pi / 8, so series suffice
  const Float half_s = half * (1 + z * (-1.0f / 6 + z * (1.0f / 120 - z * (1.0f / 5040))));
  const Float half_c = 1 + z * (-0.5f + z * (1.0f / 24 - z * (1.0f / 720)));
  const Float step_s = 2 * half_s * half_c, step_c = 1 - 2 * half_s * half_s;
  const Float per = 1 / square_root(apart * apart + first * first);
  Float s = (first * half_c + apart * half_s) * per, c = (apart * half_c - first * half_s) * per;
  Vector sum = zero();
  for (int k = 0; k < kBackscatterSamples; ++k) {
    sum = sum + lamp_scattering(view, lamp, s, max(c, splat(1e-4f)), ahead, along, nearest, apart);
    const Float turned = s * step_c + c * step_s;
    c = c * step_c - s * step_s;
    s = turned;
  }
  const Vector added = sum * broadcast(lamp.intensity) * (step / apart);
  const Vector light = load(block.radiance);
  store(block.radiance, select(crosses, light + added, light));
}

}  // namespace
}  // namespace uwsim::camera
