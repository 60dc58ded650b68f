#pragma once

#include "uwsim/camera/kernels/scattering.h"
#include "uwsim/camera/kernels/sky.h"

/// The water's surface: its waves and ripples, and refraction and reflection there. Included only by the kernels.
namespace uwsim::camera {
namespace {

/// Height and slope of the water's surface.
struct WaveSample {
  Float height, slope_x, slope_y;
};

/// The world's waves at a position, interpolated between nodes; beyond the grid, the values at its edge are used.
UWSIM_LANES WaveSample waves_at(const View& view, Float x, Float y) {
  const WaveNodes& nodes = view.waves;
  if (nodes.values == nullptr) return {splat(view.surface_z), Float{}, Float{}};
  const float last = static_cast<float>(nodes.side - 1) - 0.001f;
  const Float u = clamp((x - nodes.left_m) / nodes.spacing_m, 0, last);
  const Float v = clamp((y - nodes.bottom_m) / nodes.spacing_m, 0, last);
  const Int i = to_int(u), j = to_int(v);
  const Float fu = u - to_float(i), fv = v - to_float(j);
  const Int at = 3 * (j * nodes.side + i), above = at + 3 * nodes.side;
  const auto value = [&](int field) {
    const float* values = nodes.values + field;
    return mix(mix(gather(values, at), gather(values, at + 3), fu),
               mix(gather(values, above), gather(values, above + 3), fu), fv);
  };
  return {value(0), value(1), value(2)};
}

/// The four cells of the ripple tile around a position, and the position between them, u and v in [0, 1).
struct RippleCell {
  Int low_left, low_right, high_left, high_right;
  Float u, v;
};
UWSIM_LANES RippleCell ripple_cell(const View& view, Float x, Float y) {
  constexpr float kScale = kRippleCells / kRippleTile_m;
  const Float u = (x + view.texture_x) * kScale, v = (y + view.texture_y) * kScale;
  const Int i0 = floor_int(u), j0 = floor_int(v);
  const Float fu = u - to_float(i0), fv = v - to_float(j0);
  const Int wrap = Int{} + (kRippleCells - 1);
  const Int i = i0 & wrap, i1 = (i0 + 1) & wrap, j = (j0 & wrap) * kRippleCells, j1 = ((j0 + 1) & wrap) * kRippleCells;
  return {j + i, j + i1, j1 + i, j1 + i1, fu, fv};
}
/// Interpolates `value(cell)` bilinearly between the four cells.
template <typename Value>
UWSIM_LANES Float interpolate(const RippleCell& cell, const Value& value) {
  return mix(mix(value(cell.low_left), value(cell.low_right), cell.u),
             mix(value(cell.high_left), value(cell.high_right), cell.u), cell.v);
}

/// Adds the slopes of the ripples, as seen from `distance`.
UWSIM_LANES void add_ripples(const View& view, Float x, Float y, Float distance, WaveSample& sample) {
  if (view.slopes == nullptr) return;
  const RippleCell cell = ripple_cell(view, x, y);
  // A distant pixel covers many ripples, whose slopes cancel out.
  const Float nearness = 1 / (1 + distance * distance * (view.pixel_rad * view.pixel_rad * 40));
  const auto slope = [&](int axis) {
    return nearness * interpolate(cell, [&](Int at) { return gather(view.slopes + axis, 2 * at); });
  };
  sample.slope_x += slope(0);
  sample.slope_y += slope(1);
}

/// Radiance leaving deep water upwards.
UWSIM_LANES Vector upwelling(const View& view) {
  return broadcast(view.upwelling) * broadcast(view.total_level) * splat(1 / kPi);
}

/// Continues rays that have reached the surface along the stronger of the refracted and the reflected direction; the
/// weaker ray is assumed to reach clear sky or deep water. Radiance changes by n^2 across the surface (Mobley 1994,
/// "Light and Water", ch. 4).
void refract_or_reflect(const View& view, Block& block) {
  const Vector direction = load(block.direction);
  const Float end = load(block.reach.at);
  const Vector at = load(block.origin) + direction * end;
  const Int onward = load(block.onward.at), in_water = load(block.in_water.at);
  WaveSample sample = waves_at(view, at.x, at.y);
  add_ripples(view, at.x, at.y, end, sample);
  const Vector up = unit({-sample.slope_x, -sample.slope_y, splat(1)});
  const Vector facing = select(in_water, up * splat(-1), up);  // towards the side from which the ray comes
  const Float cosine = clamp(-dot(direction, facing), 0.02f, 1);
  const Float ratio = select(in_water, splat(view.refractive_index), splat(1 / view.refractive_index));
  const Float sine2 = ratio * ratio * (1 - cosine * cosine);
  const Int totally = sine2 >= 1;
  const Float beyond = square_root(max(1 - sine2, Float{}));
  const Float s = (ratio * cosine - beyond) / (ratio * cosine + beyond);
  const Float p = (ratio * beyond - cosine) / (ratio * beyond + cosine);
  const Float reflectance = select(totally, splat(1), 0.5f * (s * s + p * p));
  Vector refracted = unit(direction * ratio + facing * (ratio * cosine - beyond));
  Vector reflected = unit(direction + facing * (2 * cosine));
  // A ripple must not send a ray back through the surface that it came from.
  refracted.z = select(in_water, max(refracted.z, splat(0.002f)), min(refracted.z, splat(-0.002f)));
  reflected.z = select(in_water, min(reflected.z, splat(-0.002f)), max(reflected.z, splat(0.002f)));
  const Int reflects = reflectance > 0.5f;
  const Float gain = select(in_water, splat(view.refractive_index * view.refractive_index),
                            splat(1 / (view.refractive_index * view.refractive_index)));
  const Float transmitted = (1 - reflectance) * gain;
  const Vector water = upwelling(view);
  const Vector other =
      select(select(in_water, reflects, ~reflects), sky_towards(view, select(in_water, refracted, reflected)), water);
  const Float other_share = select(reflects, transmitted, reflectance);
  const Vector throughput = load(block.throughput), light = load(block.radiance);
  store(block.radiance,
        select(onward, light + throughput * other * select(totally & reflects, Float{}, other_share), light));
  store(block.throughput, throughput * select(reflects, reflectance, transmitted));
  store(block.direction, select(reflects, reflected, refracted));
  store(block.origin, {at.x, at.y, at.z});
  store(block.in_water.at, select(reflects, in_water, ~in_water));
  store(block.active.at, onward);
}

}  // namespace
}  // namespace uwsim::camera
