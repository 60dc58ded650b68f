#pragma once

#include "uwsim/camera/kernels/water_surface.h"

/// Caustics: sunlight focused by ripples and waves. Included only by the kernels.
namespace uwsim::camera {
namespace {

/// The share of the waves' focusing that is left after `path` of water. Beyond their focus, at a path of 1 / (bend
/// curvature), the sheets of light from several waves overlap and even out; the water spreads them (`pattern_left` in
/// caustics.h).
UWSIM_LANES Float swell_left(const View& view, Float path) {
  const Float beyond = path * (view.bend * view.swell_curvature), x = path * (view.focus_rad * view.swell_per_m);
  const Float kept = select(x > 1e-3f, (1 - exponential(-x)) / max(x, splat(1e-3f)), 1 - 0.5f * x);
  return exponential(-view.focus_b * path * (1 - kept)) / (1 + beyond * beyond);
}

/// Downwelling light relative to its mean, focused and spread by the slopes of the ripples (Ripples::Snapshot) and of
/// the waves, if any: 1 / |det(1 + d bend H)|, where H is the curvature of the surface above, at most 3, as far as it
/// is left.
UWSIM_LANES Float caustic_at(const View& view, Vector point) {
  const Float depth = max(view.surface_z - (point.z + view.camera_z), Float{});
  const Float path = depth * (1 / view.to_sun_in_water[2]);
  Float x = point.x + path * view.to_sun_in_water[0], y = point.y + path * view.to_sun_in_water[1];
  Float swell = splat(1);
  if (view.waves.values != nullptr) {
    const Float step = splat(view.waves.spacing_m);
    const WaveSample here = waves_at(view, x, y), east = waves_at(view, x + step, y),
                     north = waves_at(view, x, y + step);
    const Float lens = path * view.bend / step * swell_left(view, path);
    const Float xx = 1 + lens * (east.slope_x - here.slope_x), yy = 1 + lens * (north.slope_y - here.slope_y);
    const Float xy = lens * (north.slope_x - here.slope_x);
    swell = 1 / max(abs(xx * yy - xy * xy), splat(1.0f / 3));
    x -= path * view.bend * here.slope_x;
    y -= path * view.bend * here.slope_y;
  }
  const RippleCell cell = ripple_cell(view, x, y);
  const Float level = 1.44269504f * logarithm(max(path * (1 / kFirstCausticLevel_m), splat(1)));
  const Float bounded = clamp(level, 0, kCausticLevels - 1.001f);
  const Int lower = to_int(bounded);
  const Float between = bounded - to_float(lower);
  const auto layer = [&](int above) {
    return interpolate(cell, [&](Int at) { return gather(view.caustics + above, at * kCausticLevels + lower); });
  };
  const Float light = mix(layer(0), layer(1), between);
  // The pattern develops between the surface and the first level, and fades beyond the last.
  constexpr float kLast_m = kFirstCausticLevel_m * (1 << (kCausticLevels - 1));
  const Float developed =
      min(path * (1 / kFirstCausticLevel_m), splat(1)) * min(kLast_m / max(path, splat(1)), splat(1));
  return swell * mix(splat(1), light, developed);
}

}  // namespace
}  // namespace uwsim::camera
