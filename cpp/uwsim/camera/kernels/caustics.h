#pragma once

#include "uwsim/camera/kernels/water_surface.h"

/// Caustics: sunlight focused by ripples and waves. Included only by the kernels.
namespace uwsim::camera {
namespace {

/// How far slopes move the sun's light on a level plane per metre of its path (`moved_on_level` in caustics.h).
struct Moved {
  Float x, y;
};
UWSIM_LANES Moved moved_by(const View& view, const WaveSample& sample) {
  const Float along = sample.slope_x * view.slant[0] + sample.slope_y * view.slant[1];
  return {view.bend * (sample.slope_x + along * view.slant[0]), view.bend * (sample.slope_y + along * view.slant[1])};
}

/// Downwelling light relative to its mean, focused and spread by the slopes of the ripples (Ripples::Snapshot) and of
/// the waves, if any: 1 / |det(1 + path dm / dx)|, where m is the movement by the surface's slopes above, at most 3, as
/// far as it is left.
UWSIM_LANES Float caustic_at(const View& view, Vector point) {
  const Float depth = max(view.surface_z - (point.z + view.camera_z), Float{});
  const Float path = depth * (1 / view.to_sun_in_water[2]);
  Float x = point.x + path * view.to_sun_in_water[0], y = point.y + path * view.to_sun_in_water[1];
  const Float level = 1.44269504f * logarithm(max(path * (1 / kFirstCausticLevel_m), splat(1)));
  const Float bounded = clamp(level, 0, kCausticLevels - 1.001f);
  const Int lower = to_int(bounded);
  const Float between = bounded - to_float(lower);
  constexpr float kLast_m = kFirstCausticLevel_m * (1 << (kCausticLevels - 1));
  const Float beyond = min(kLast_m / max(path, splat(1)), splat(1));  // the last level
  Float swell = splat(1);
  if (view.waves.values != nullptr) {
    const Float step = splat(view.waves.spacing_m);
    const Moved here = moved_by(view, waves_at(view, x, y)), east = moved_by(view, waves_at(view, x + step, y)),
                north = moved_by(view, waves_at(view, x, y + step));
    const Float left = mix(gather(view.swell_left, lower), gather(view.swell_left, lower + 1), between);
    const Float lens = path / step * (left * beyond * beyond);
    const Float xx = 1 + lens * (east.x - here.x), yy = 1 + lens * (north.y - here.y);
    swell = 1 / max(abs(xx * yy - lens * lens * (north.x - here.x) * (east.y - here.y)), splat(1.0f / 3));
    x -= path * here.x;
    y -= path * here.y;
  }
  const RippleCell cell = ripple_cell(view, x, y);
  const auto layer = [&](int above) {
    return interpolate(cell, [&](Int at) { return gather(view.caustics + above, at * kCausticLevels + lower); });
  };
  const Float light = mix(layer(0), layer(1), between);
  // The pattern develops between the surface and the first level, and fades beyond the last.
  const Float developed = min(path * (1 / kFirstCausticLevel_m), splat(1)) * beyond;
  return swell * mix(splat(1), light, developed);
}

}  // namespace
}  // namespace uwsim::camera
