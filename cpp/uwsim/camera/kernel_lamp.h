#pragma once

#include "uwsim/camera/kernel_surface.h"

/// A lamp's light in the water between eye and scene, and shafts of sunlight. Included by kernel_*.cpp only.
namespace uwsim::camera {
namespace {

constexpr int kVeilSamples = 4;

/// Where a ray is within the lamp's outer cone: from..to along it, empty where from >= to.
UWSIM_LANES void cone_crossing(const LampLight& lamp, Vector way, Float end, Float& from, Float& to) {
  const Vector m = spread(lamp.position) * splat(-1), axis = spread(lamp.axis);
  const float cos2 = lamp.cos_outer * lamp.cos_outer;
  const Float da = dot(way, axis), ma = dot(m, axis);
  const Float a = da * da - cos2, b = da * ma - cos2 * dot(way, m), c = ma * ma - cos2 * dot(m, m);
  const Float inside = b * b - a * c;
  const Int misses = inside < 0;
  const Float root = square_root(max(inside, Float{}));
  const Float safe = select(abs(a) < 1e-6f, splat(1e-6f), a);
  const Float t1 = (-b - root) / safe, t2 = (-b + root) / safe;
  const Float low = min(t1, t2), high = max(t1, t2);
  // Outside the cone's own directions a ray is in it between the roots; along them, beyond the last or before the
  // first.
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

/// The lamp's light that water at one place scatters towards the eye, dimmed on both ways, but for intensity / apart.
/// `s`, `c`: sine and cosine of the angle at the lamp between the ray's nearest point and the place; s is the cosine of
/// the angle by which light turns, too. `ahead`, `along`: the cone's cosine is ahead c + along s.
UWSIM_LANES Vector lamp_scattered(const Shot& shot, const LampLight& lamp, Float s, Float c, Float ahead, Float along,
                                  Float nearest, Float apart) {
  constexpr float g = kLampAsymmetry;
  const Float spot = smooth((ahead * c + along * s - lamp.cos_outer) * (1 / (lamp.cos_inner - lamp.cos_outer)));
  // Of forward_phase(-s, g) = (1 - g^2) / (4 pi) / cube and path = nearest + apart (1 + s) / c with one division.
  const Float side = 1 + g * g + 2 * g * s, cube = side * square_root(side), per = 1 / (cube * c);
  const Float path = nearest + apart * ((1 + s) * (cube * per));
  const Float particles = spot * (c * per) * ((1 - g * g) / (4 * kPi)), molecules = spot * molecule_phase(s);
  const Vector light = spread(shot.particle_b) * particles + spread(shot.molecule_b) * molecules;
  return shot.has_attenuation ? light * exponential(spread(shot.c) * -path) : light;
}

/// Single scattering of the lamp's light into the ray, in points spread evenly over the angle at the lamp (Kulla and
/// Fajardo 2012, "Importance sampling techniques for path tracing in participating media"): dt / distance^2 = d angle /
/// closest distance, so that the lamp's peak costs nothing. Unshadowed.
void lamp_veil(const Shot& shot, int index, Block& block) {
  const LampLight& lamp = shot.lamps[index];
  const Vector way = load(block.direction);
  const Int active = load(block.active.at) & load(block.wet.at);
  // Past eight attenuation lengths nothing comes back.
  const Float end = min(load(block.reach.at), splat(8 / shot.c[1]));
  Float from, to;
  cone_crossing(lamp, way, end, from, to);
  const Int crosses = active & (to > from);
  if (!any(crosses)) return;
  const Vector lamp_at = spread(lamp.position), axis = spread(lamp.axis);
  const Float nearest = dot(lamp_at, way);
  const Float apart = square_root(max(dot(lamp_at, lamp_at) - nearest * nearest, splat(1e-4f)));
  const Float along = dot(way, axis), ahead = (along * nearest - dot(lamp_at, axis)) / apart;
  const Float first = from - nearest, last = to - nearest;
  const Float step = angle_of(apart * apart + first * last, apart * (last - first)) * (1.0f / kVeilSamples);
  const Float half = 0.5f * step, z = half * half;  // at most pi / 8: series
  const Float half_s = half * (1 + z * (-1.0f / 6 + z * (1.0f / 120 - z * (1.0f / 5040))));
  const Float half_c = 1 + z * (-0.5f + z * (1.0f / 24 - z * (1.0f / 720)));
  const Float step_s = 2 * half_s * half_c, step_c = 1 - 2 * half_s * half_s;
  const Float per = 1 / square_root(apart * apart + first * first);
  Float s = (first * half_c + apart * half_s) * per, c = (apart * half_c - first * half_s) * per;
  Vector sum = zero();
  for (int k = 0; k < kVeilSamples; ++k) {
    sum = sum + lamp_scattered(shot, lamp, s, max(c, splat(1e-4f)), ahead, along, nearest, apart);
    const Float turned = s * step_c + c * step_s;
    c = c * step_c - s * step_s;
    s = turned;
  }
  const Vector added = sum * spread(lamp.intensity) * (step / apart);
  const Vector light = load(block.light);
  store(block.light, select(crosses, light + added, light));
}

/// A point of each ray, at a share of what is worth sampling of it, and a shadow ray to the sun. The same share for all
/// rays, so that what the surface bundles shows as shafts.
void shaft_point(const Shot& shot, float share, Block& block) {
  const Float t = min(load(block.reach.at), splat(3 / shot.c[1])) * share;
  const Vector point = load(block.origin) + load(block.direction) * t;
  const Float depth = max(shot.surface_z - (point.z + shot.camera_z), Float{});
  store(block.distance.at, t);
  store(block.point, point);
  store(block.to_light, spread(shot.to_sun_wet));
  store(block.light_distance.at, depth * (1 / shot.to_sun_wet[2]) + kShadowReach_m);
  store(block.wants.at, load(block.active.at) & load(block.wet.at));
}

/// How much the light at that point weighs, and the caustics there.
void shaft_light(const Shot& shot, const Block& block, Row& weight, Row& caustic) {
  const Float t = load(block.distance.at);
  store(weight.at, exponential(t * (-shot.c[1] + shot.kb[1] * load(block.direction.z.at))));
  store(caustic.at, shot.has_caustics ? caustic_at(shot, load(block.point)) : splat(1));
}

}  // namespace
}  // namespace uwsim::camera
