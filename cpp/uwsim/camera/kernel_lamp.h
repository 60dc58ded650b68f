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
  const Vector lamp_at = spread(lamp.position);
  const Float nearest = dot(lamp_at, way);
  const Float apart = square_root(max(dot(lamp_at, lamp_at) - nearest * nearest, splat(1e-4f)));
  const Float first = arc_tangent((from - nearest) / apart), last = arc_tangent((to - nearest) / apart);
  const Float step = (last - first) * (1.0f / kVeilSamples);
  Vector sum = zero();
  for (int k = 0; k < kVeilSamples; ++k) {
    const Float angle = first + step * (0.5f + static_cast<float>(k));
    const Float s = sine(angle), c = max(cosine(angle), splat(1e-4f));
    const Float t = nearest + apart * s / c, distance = apart / c;
    const Vector from_lamp = (way * t - lamp_at) * (1 / distance);
    const Float cone = dot(from_lamp, spread(lamp.axis));
    const Float spot = smooth((cone - lamp.cos_outer) * (1 / (lamp.cos_inner - lamp.cos_outer)));
    Vector light = scattered(shot, -dot(from_lamp, way), kLampAsymmetry) * spot;
    if (shot.has_attenuation) light = light * exponential(spread(shot.c) * (-(t + distance)));
    sum = sum + light;
  }
  const Vector added = sum * spread(lamp.intensity) * (step / apart);
  const Vector light = load(block.light);
  store(block.light, select(crosses, light + added, light));
}

/// A point of each ray, at a share of what is worth sampling of it: how much its light weighs, the caustics there, and
/// a shadow ray to the sun. The same share for all rays, so that what the surface bundles shows as shafts.
void shaft_sample(const Shot& shot, float share, Block& block, Row& weight, Row& caustic) {
  const Vector way = load(block.direction);
  const Float t = min(load(block.reach.at), splat(3 / shot.c[1])) * share;
  const Vector point = load(block.origin) + way * t;
  const Float depth = max(shot.surface_z - (point.z + shot.camera_z), Float{});
  store(weight.at, exponential(t * (-shot.c[1] + shot.kb[1] * way.z)));
  store(caustic.at, shot.has_caustics ? caustic_at(shot, point) : splat(1));
  store(block.point, point);
  store(block.to_light, spread(shot.to_sun_wet));
  store(block.light_distance.at, depth * (1 / shot.to_sun_wet[2]) + kShadowReach_m);
  store(block.wants.at, load(block.active.at) & load(block.wet.at));
}

}  // namespace
}  // namespace uwsim::camera
