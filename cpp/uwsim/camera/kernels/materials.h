#pragma once

#include "uwsim/camera/kernels/detail.h"
#include "uwsim/camera/kernels/scattering.h"

/// Procedural materials: albedo and relief of surfaces. Included only by the kernels.
namespace uwsim::camera {
namespace {

/// Value noise in [0, 1]: hashed values at integer points, interpolated smoothly. `first_x`, `first_y`: the cell of
/// p = 0, so that p is small and therefore exact anywhere in the world.
UWSIM_LANES Float value_noise(Vector p, std::uint32_t salt, Unsigned first_x, Unsigned first_y) {
  const Int i = floor_int(p.x), j = floor_int(p.y), k = floor_int(p.z);
  const Float u = p.x - to_float(i), v = p.y - to_float(j), w = p.z - to_float(k);
  const Float su = u * u * (3 - 2 * u), sv = v * v * (3 - 2 * v), sw = w * w * (3 - 2 * w);
  const Unsigned x0 = (bits_as<std::uint32_t>(i) + first_x) * 0x8da6b343u, x1 = x0 + 0x8da6b343u;
  const Unsigned y0 = (bits_as<std::uint32_t>(j) + first_y) * 0xd8163841u, y1 = y0 + 0xd8163841u;
  const Unsigned z0 = bits_as<std::uint32_t>(k) * 0xcb1ab31fu + salt, z1 = z0 + 0xcb1ab31fu;
  const auto row = [&](Unsigned y, Unsigned z) { return mix(hash_unit(x0 ^ y ^ z), hash_unit(x1 ^ y ^ z), su); };
  return mix(mix(row(y0, z0), row(y1, z0), sv), mix(row(y0, z1), row(y1, z1), sv), sw);
}

/// A Material for each lane.
struct MaterialLanes {
  Vector base, other;
  Float contrast, fine_per_m, bump, ripple_m, ripple_tilt;
};
UWSIM_LANES MaterialLanes material_lanes(const Material& m) {
  return {broadcast(m.base), broadcast(m.other), splat(m.contrast),   splat(m.fine_per_m),
          splat(m.bump),     splat(m.ripple_m),  splat(m.ripple_tilt)};
}
UWSIM_LANES MaterialLanes material_lanes(const Material* materials, Int index) {
  const Int first(index[0]);
  if (!any(~(index == first))) return material_lanes(materials[index[0]]);
  MaterialLanes all{};
  for (int k = 0; k < kLanes; ++k) {
    const Material& m = materials[index[k]];
    all.base.x[k] = m.base[0], all.base.y[k] = m.base[1], all.base.z[k] = m.base[2];
    all.other.x[k] = m.other[0], all.other.y[k] = m.other[1], all.other.z[k] = m.other[2];
    all.contrast[k] = m.contrast, all.fine_per_m[k] = m.fine_per_m, all.bump[k] = m.bump;
    all.ripple_m[k] = m.ripple_m, all.ripple_tilt[k] = m.ripple_tilt;
  }
  return all;
}

/// The factor of an image's albedo by the material's detail between its texels, whose mean is 1.
UWSIM_LANES Vector shade_of_detail(const MaterialLanes& look, Float pattern) {
  const Float share = clamp(0.5f + pattern, 0, 1);
  const auto band = [&](Float base, Float other) {
    return (mix(base, other, share) + 1e-6f) / (mix(base, other, splat(0.5f)) + 1e-6f);
  };
  return {band(look.base.x, look.other.x), band(look.base.y, look.other.y), band(look.base.z, look.other.z)};
}

/// The upward part of the terrain's normal as if it had no facets: from slopes at its nodes, interpolated.
UWSIM_LANES Float terrain_upright(const View& view, Vector point) {
  const auto per_m = static_cast<float>(1 / view.terrain_spacing);
  const Float u = (point.x - static_cast<float>(view.terrain_x)) * per_m;
  const Float v = (point.y - static_cast<float>(view.terrain_y)) * per_m;
  const Float i = clamp(to_float(floor_int(u)), 1, static_cast<float>(view.terrain_nx - 3));
  const Float j = clamp(to_float(floor_int(v)), 1, static_cast<float>(view.terrain_ny - 3));
  const Float across = clamp(u - i, 0, 1), along = clamp(v - j, 0, 1);
  const Int at = to_int(j) * view.terrain_nx + to_int(i);
  const auto height = [&](int east, int north) { return gather(view.heights, at + (north * view.terrain_nx + east)); };
  const auto slope_x = [&](int east, int north) { return height(east + 1, north) - height(east - 1, north); };
  const auto slope_y = [&](int east, int north) { return height(east, north + 1) - height(east, north - 1); };
  const auto between = [&](const auto& slope) {
    return mix(mix(slope(0, 0), slope(1, 0), across), mix(slope(0, 1), slope(1, 1), across), along) * (0.5f * per_m);
  };
  const Float x = between(slope_x), y = between(slope_y);
  return 1 / square_root(1 + x * x + y * y);
}

/// Sets the albedo and tilts the normal, with patches of two sizes, grain and sand ripples. Each of these fades out as
/// its features become smaller than a pixel.
void apply_material(const View& view, Block& block) {
  const Vector point = load(block.point), direction = load(block.direction);
  Vector normal = load(block.normal);
  normal = select(dot(normal, direction) > 0, normal * splat(-1), normal);
  const Vector at = {point.x + view.texture_x, point.y + view.texture_y, point.z + view.camera_z};
  const Float pixel_m = square_root(dot(point, point)) * view.pixel_rad;
  const Vector patch = {at.x * kPatch_per_m + view.patch_x, at.y * kPatch_per_m + view.patch_y, at.z * kPatch_per_m};
  const Float large = value_noise(patch, 17u, Unsigned(view.patch_cell_x), Unsigned(view.patch_cell_y));
  Int material = load(block.material.at);
  const Int on_terrain = material == 0;
  const Float steepest = 0.72f + 0.16f * large;
  Float upright = normal.z;
  const Int unsure = on_terrain & (abs(upright - steepest) < 0.2f);
  if (view.terrain_nx > 3 && view.terrain_ny > 3 && any(unsure))
    upright = select(unsure, terrain_upright(view, point), upright);
  const Int on_land = on_terrain & (at.z > 0.2f + 1.5f * large), steep = on_terrain & (upright < steepest);
  material = select(on_land, Int(view.land_material), select(steep, Int(view.steep_material), material));
  const MaterialLanes look = material_lanes(view.materials, material);
  const Float fine_near = clamp(1.5f - 1.5f * pixel_m * look.fine_per_m, 0, 1);
  const Float grain_near = clamp(1.5f - 13.0f * pixel_m * look.fine_per_m, 0, 1);
  const Int lit = load(block.lit.at);
  const Unsigned per_m = bits_as<std::uint32_t>(floor_int(look.fine_per_m));  // whole, in all materials
  const Unsigned cell_x = per_m * view.texture_first_x, cell_y = per_m * view.texture_first_y;
  Float fine{}, grain{};
  if (any(lit & (fine_near > 0))) fine = value_noise(at * look.fine_per_m, 91u, cell_x, cell_y) - 0.5f;
  if (any(lit & (grain_near > 0))) {
    grain = value_noise(at * (look.fine_per_m * 9.0f), 53u, cell_x * 9u, cell_y * 9u) - 0.5f;
  }
  const Float patches = (large - 0.5f) * 0.9f + fine * fine_near * 0.7f + grain * grain_near * 0.9f;
  Float share = 0.5f + look.contrast * patches;
  const Int has_texture = load(block.has_texture.at);
  DetailLanes detail{Float{}, splat(1), {Float{}, Float{}, Float{}}};
  if (view.detail_end > 0) {
    const Float slant = max(abs(dot(normal, direction)), splat(0.1f));
    const Int has_detail = lit & (material < Int(view.detail_end));
    const Float texel_m = select(has_texture, load(block.texel_m.at), splat(1e6f));
    detail = detail_lanes(view, material, has_detail, ~has_texture, at, normal, pixel_m / slant, texel_m);
    share += detail.pattern;
  }
  share = clamp(share, 0, 1);
  Vector albedo = {mix(look.base.x, look.other.x, share), mix(look.base.y, look.other.y, share),
                   mix(look.base.z, look.other.z, share)};
  if (any(has_texture)) {
    Vector image = load(block.texture_albedo);
    if (view.detail_end > 0) image = image * shade_of_detail(look, detail.pattern);
    albedo = select(has_texture, image, albedo);
  }
  const Float ripple_near = clamp(1.5f - 4.0f * pixel_m / max(look.ripple_m, splat(1e-3f)), 0, 1);
  const Float crest_m = max(look.ripple_m, splat(0.02f)), crests = view.ripple_first_m / crest_m;
  const Float begun_m = view.ripple_first_m - crest_m * to_float(floor_int(crests));
  const Float crest = (at.x * view.ripple_x + at.y * view.ripple_y + 0.35f * large + begun_m) * (2 * kPi) / crest_m;
  const Float ripple =
      select(look.ripple_m > 0, look.ripple_tilt * ripple_near * cosine(crest) * (0.4f + large), Float{});
  Vector tilted = {normal.x - ripple * view.ripple_x + look.bump * fine_near * fine,
                   normal.y - ripple * view.ripple_y + look.bump * grain_near * grain, normal.z};
  if (view.detail_end > 0) {
    albedo = albedo * min(detail.shade, splat(2));
    tilted = tilted - (detail.slope - normal * dot(detail.slope, normal));
  }
  store(block.normal, unit(tilted));
  store(block.albedo, albedo);
}

}  // namespace
}  // namespace uwsim::camera
