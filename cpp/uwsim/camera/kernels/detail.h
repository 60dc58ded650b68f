#pragma once

#include "uwsim/camera/kernels/scattering.h"

/// Relief and patterns finer than a material's grain, down to the footprint of a pixel. Included only by the kernels.
namespace uwsim::camera {
namespace {

constexpr int kGritOctaves = 6;
constexpr std::uint32_t kGritStep = 2, kSpotStep = 3;  // whole, for the patterns' places in the world

struct NoiseSlope {
  Float value;   ///< in [0, 1]
  Vector slope;  ///< per cell
};

/// Value noise as in materials.h, with its gradient.
UWSIM_LANES NoiseSlope sloped_noise(Vector p, std::uint32_t salt, Unsigned first_x, Unsigned first_y) {
  const Int i = floor_int(p.x), j = floor_int(p.y), k = floor_int(p.z);
  const Float u = p.x - to_float(i), v = p.y - to_float(j), w = p.z - to_float(k);
  const Float su = u * u * (3 - 2 * u), sv = v * v * (3 - 2 * v), sw = w * w * (3 - 2 * w);
  const Unsigned x0 = (bits_as<std::uint32_t>(i) + first_x) * 0x8da6b343u, x1 = x0 + 0x8da6b343u;
  const Unsigned y0 = (bits_as<std::uint32_t>(j) + first_y) * 0xd8163841u, y1 = y0 + 0xd8163841u;
  const Unsigned z0 = bits_as<std::uint32_t>(k) * 0xcb1ab31fu + salt, z1 = z0 + 0xcb1ab31fu;
  const Float a = hash_unit(x0 ^ y0 ^ z0), b = hash_unit(x1 ^ y0 ^ z0), c = hash_unit(x0 ^ y1 ^ z0),
              d = hash_unit(x1 ^ y1 ^ z0), e = hash_unit(x0 ^ y0 ^ z1), f = hash_unit(x1 ^ y0 ^ z1),
              g = hash_unit(x0 ^ y1 ^ z1), h = hash_unit(x1 ^ y1 ^ z1);
  const Float south = mix(mix(a, b, su), mix(e, f, su), sw), north = mix(mix(c, d, su), mix(g, h, su), sw);
  const Float low = mix(mix(a, b, su), mix(c, d, su), sv), high = mix(mix(e, f, su), mix(g, h, su), sv);
  const Float along_x = mix(mix(b - a, d - c, sv), mix(f - e, h - g, sv), sw);
  return {mix(low, high, sw),
          {along_x * (6 * u * (1 - u)), (north - south) * (6 * v * (1 - v)), (high - low) * (6 * w * (1 - w))}};
}

/// The details of a surface, for each lane.
struct DetailLanes {
  Float pattern;  ///< added to the share of the second colour
  Float shade;    ///< factor of the albedo
  Vector slope;   ///< of the relief, subtracted from the normal
};

/// Noise in octaves. An octave fades out before its cells become smaller than two pixels, or larger than the texels of
/// an image on the surface, and the layers of a stratified material are thinner than they are long.
UWSIM_LANES void add_grit(const View& view, const MaterialDetail& look, Int mask, Vector at, Float pixel_m,
                          Float texel_m, DetailLanes& out) {
  if (!(look.grit_slope > 0 || look.grit_contrast > 0)) return;
  auto whole_per_m = static_cast<std::uint32_t>(look.grit_per_m);
  float weight = 1;
  for (std::uint32_t octave = 0; octave < kGritOctaves; ++octave, whole_per_m *= kGritStep, weight *= 0.85f) {
    const auto per_m = static_cast<float>(whole_per_m);
    const Float sharp = select(mask, clamp(2 - 4.0f * per_m * pixel_m, 0, 1), Float{});
    if (!any(sharp > 0)) return;
    const Float near = sharp * clamp(per_m * texel_m - 1, 0, 1);
    if (!any(near > 0)) continue;
    const Vector p = {at.x * per_m, at.y * per_m, at.z * (per_m * look.flatness)};
    const NoiseSlope noise = sloped_noise(p, 211u + 29u * octave, Unsigned(whole_per_m * view.texture_first_x),
                                          Unsigned(whole_per_m * view.texture_first_y));
    out.pattern += near * (noise.value - 0.5f) * (weight * look.grit_contrast);
    out.slope = out.slope + noise.slope * (near * (weight * look.grit_slope));
  }
}

/// Pebbles, shells' fragments, or pits, of two sizes: a cell of a grid on the surface has one at most, with a place, a
/// size and a shade of its own, at whose foot less light arrives.
UWSIM_LANES void add_spots(const View& view, const MaterialDetail& look, Int mask, Vector at, Vector normal,
                           Float pixel_m, DetailLanes& out) {
  if (!(look.spot_share > 0)) return;
  const Int level = abs(normal.z) > 0.6f, faces_x = ~level & (abs(normal.x) > abs(normal.y));
  const Float a = select(faces_x, at.y, at.x), b = select(level, at.y, at.z);
  auto whole_per_m = static_cast<std::uint32_t>(look.spots_per_m);
  for (int size = 0; size < 2; ++size, whole_per_m *= kSpotStep) {
    const auto per_m = static_cast<float>(whole_per_m);
    const Float near = select(mask, clamp(2 - 6.0f * per_m * pixel_m, 0, 1), Float{});
    if (!any(near > 0)) return;
    const Float x = a * per_m, y = b * per_m;
    const Int i = floor_int(x), j = floor_int(y);
    const Unsigned first_x = Unsigned(whole_per_m * view.texture_first_x),
                   first_y = Unsigned(whole_per_m * view.texture_first_y);
    const Unsigned first_a = bits_as<std::uint32_t>(faces_x) & first_y,
                   other_a = ~bits_as<std::uint32_t>(faces_x) & first_x,
                   first_b = bits_as<std::uint32_t>(level) & first_y;
    const Unsigned cell =
        (bits_as<std::uint32_t>(i) + (first_a | other_a)) * 0x8da6b343u ^
        ((bits_as<std::uint32_t>(j) + first_b) * 0xd8163841u + (size == 0 ? 0x1b873593u : 0xcc9e2d51u));
    const Float one = hash_unit(cell), two = hash_unit(cell + 0x9e3779b9u), three = hash_unit(cell + 0x3c6ef372u),
                four = hash_unit(cell + 0xdaa66d2bu), five = hash_unit(cell + 0x78dde6e4u);
    const Float radius = 0.12f + 0.24f * three * three, room = 1 - 3.0f * radius;
    const Float du = (x - to_float(i) - (1.5f * radius + room * one)) / radius;
    const Float dv = (y - to_float(j) - (1.5f * radius + room * two)) / radius * (1 + 0.35f * four);
    const Float away = du * du + dv * dv;
    const Int there = five < look.spot_share;
    const Float inside = select(there, near * clamp(3 - 3.0f * away, 0, 1), Float{});
    const Float foot = select(there, near * clamp(1 - abs(away - 1.2f) * 1.5f, 0, 1), Float{});
    const Float tint = look.spot_shade * (1 + look.spot_spread * (2 * four - 1));
    out.shade = out.shade * (1 + inside * (tint - 1)) * (1 - 0.5f * foot);
    const Float rise = inside * -look.spot_rise;
    const Float along_a = rise * du, along_b = rise * dv;
    out.slope.x += select(faces_x, Float{}, along_a);
    out.slope.y += select(level, along_b, select(faces_x, along_a, Float{}));
    out.slope.z += select(level, Float{}, along_b);
  }
}

/// A lane's `pixel_m` is the longer side of its pixel's footprint on the surface, and `texel_m` the side of the texels
/// of an image there, which is large where there is none. `lit` lanes only; `bare` ones have no image.
UWSIM_LANES DetailLanes detail_lanes(const View& view, Int material, Int lit, Int bare, Vector at, Vector normal,
                                     Float pixel_m, Float texel_m) {
  DetailLanes out{Float{}, splat(1), {Float{}, Float{}, Float{}}};
  Int left = lit;
  for (int k = 0; k < kLanes; ++k) {
    if (left[k] == 0) continue;
    const Int same = left & (material == Int(material[k]));
    left = left & ~same;
    const MaterialDetail& look = view.materials[material[k]].detail;
    add_grit(view, look, same, at, pixel_m, texel_m, out);
    add_spots(view, look, same & bare, at, normal, pixel_m, out);
  }
  return out;
}

}  // namespace
}  // namespace uwsim::camera
