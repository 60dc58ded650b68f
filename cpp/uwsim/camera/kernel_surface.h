#pragma once

#include "uwsim/camera/kernel_water.h"

/// What surfaces look like and what daylight does to them. Included by kernel_*.cpp only.
namespace uwsim::camera {
namespace {

constexpr float kPatch_per_m = 0.7f;
constexpr float kShadowReach_m = 5.0f;  // above the water: what stands higher casts no shadow into it
constexpr float kWorthAShadow = 2e-3f;  // of the water's own brightness: less is not missed

/// Value noise in [0, 1]: hashed values at whole points, smoothly between them. Repeats every 256 m at whole
/// frequencies.
UWSIM_LANES Float value_noise(Vector p, std::uint32_t salt) {
  const Int i = floor_int(p.x), j = floor_int(p.y), k = floor_int(p.z);
  const Float u = p.x - to_float(i), v = p.y - to_float(j), w = p.z - to_float(k);
  const Float su = u * u * (3 - 2 * u), sv = v * v * (3 - 2 * v), sw = w * w * (3 - 2 * w);
  const Unsigned x0 = bits_as<std::uint32_t>(i) * 0x8da6b343u, x1 = x0 + 0x8da6b343u;
  const Unsigned y0 = bits_as<std::uint32_t>(j) * 0xd8163841u, y1 = y0 + 0xd8163841u;
  const Unsigned z0 = bits_as<std::uint32_t>(k) * 0xcb1ab31fu + salt, z1 = z0 + 0xcb1ab31fu;
  const auto row = [&](Unsigned y, Unsigned z) { return mix(hash_unit(x0 ^ y ^ z), hash_unit(x1 ^ y ^ z), su); };
  return mix(mix(row(y0, z0), row(y1, z0), sv), mix(row(y0, z1), row(y1, z1), sv), sw);
}

struct Look {
  Vector base, other;
  Float contrast, fine_per_m, bump, ripple_m, ripple_tilt;
};

UWSIM_LANES Look look_of(const MaterialRow& m) {
  return {spread(m.base), spread(m.other),   splat(m.contrast),   splat(m.fine_per_m),
          splat(m.bump),  splat(m.ripple_m), splat(m.ripple_tilt)};
}

UWSIM_LANES Look look_of(const MaterialRow* rows, Int index) {
  bool alike = true;
  for (int k = 1; k < kLanes; ++k) alike = alike && index[k] == index[0];
  if (alike) return look_of(rows[index[0]]);
  Look look{};
  for (int k = 0; k < kLanes; ++k) {
    const MaterialRow& m = rows[index[k]];
    look.base.x[k] = m.base[0], look.base.y[k] = m.base[1], look.base.z[k] = m.base[2];
    look.other.x[k] = m.other[0], look.other.y[k] = m.other[1], look.other.z[k] = m.other[2];
    look.contrast[k] = m.contrast, look.fine_per_m[k] = m.fine_per_m, look.bump[k] = m.bump;
    look.ripple_m[k] = m.ripple_m, look.ripple_tilt[k] = m.ripple_tilt;
  }
  return look;
}

/// Fills albedo and bends the normal: patches of two sizes, sand ripples; all fade where a pixel is as large as they
/// are.
void paint(const Shot& shot, Block& block) {
  const Vector point = load(block.point), way = load(block.direction);
  Vector normal = load(block.normal);
  normal = select(dot(normal, way) > 0, normal * splat(-1), normal);
  const Vector place = {point.x + shot.texture_x, point.y + shot.texture_y, point.z + shot.camera_z};
  const Float pixel_m = square_root(dot(point, point)) * shot.pixel_rad;
  const Float large = value_noise(place * splat(kPatch_per_m), 17u);
  Int material = load(block.material.at);
  const Int ground = material == 0;
  const Int dry = ground & (place.z > 0.2f + 1.5f * large), steep = ground & (normal.z < 0.72f + 0.16f * large);
  material = select(dry, Int(shot.terrain_dry), select(steep, Int(shot.terrain_rock), material));
  const Look look = look_of(shot.materials, material);
  const Float fine_near = clamp(1.5f - 1.5f * pixel_m * look.fine_per_m, 0, 1);
  const Float fine = value_noise(place * look.fine_per_m, 91u) - 0.5f;
  const Float grain = value_noise(place * (look.fine_per_m * 9.0f), 53u) - 0.5f;
  const Float grain_near = clamp(1.5f - 13.0f * pixel_m * look.fine_per_m, 0, 1);
  const Float patches = (large - 0.5f) * 0.9f + fine * fine_near * 0.7f + grain * grain_near * 0.9f;
  const Float share = clamp(0.5f + look.contrast * patches, 0, 1);
  Vector albedo = {mix(look.base.x, look.other.x, share), mix(look.base.y, look.other.y, share),
                   mix(look.base.z, look.other.z, share)};
  albedo = select(load(block.has_given.at), load(block.given), albedo);
  const Float ripple_near = clamp(1.5f - 4.0f * pixel_m / max(look.ripple_m, splat(1e-3f)), 0, 1);
  const Float crest =
      (place.x * 0.83f + place.y * 0.56f + 0.35f * large) * (2 * kPi) / max(look.ripple_m, splat(0.02f));
  const Float ripple =
      select(look.ripple_m > 0, look.ripple_tilt * ripple_near * cosine(crest) * (0.4f + large), Float{});
  const Vector bent = {normal.x - ripple * 0.83f + look.bump * fine_near * fine,
                       normal.y - ripple * 0.56f + look.bump * grain_near * grain, normal.z};
  store(block.normal, unit(bent));
  store(block.albedo, albedo);
}

/// Light on its way down is bundled and spread by the ripples' slopes (Ripples::Moment) and, where there are waves, by
/// theirs: 1 / |det(1 + d bend H)| with H the curvature of the surface above, at most 3.
UWSIM_LANES Float caustic_at(const Shot& shot, Vector point) {
  const Float depth = max(shot.surface_z - (point.z + shot.camera_z), Float{});
  const Float path = depth * (1 / shot.to_sun_wet[2]);
  Float x = point.x + path * shot.to_sun_wet[0], y = point.y + path * shot.to_sun_wet[1];
  Float swell = splat(1);
  if (shot.waves.cells != nullptr) {
    const Float step = splat(shot.waves.spacing);
    const Sheet here = waves_at(shot, x, y), east = waves_at(shot, x + step, y), north = waves_at(shot, x, y + step);
    const Float lens = path * shot.bend / step;
    const Float xx = 1 + lens * (east.slope_x - here.slope_x), yy = 1 + lens * (north.slope_y - here.slope_y);
    const Float xy = lens * (north.slope_x - here.slope_x);
    swell = 1 / max(abs(xx * yy - xy * xy), splat(1.0f / 3));
    x -= path * shot.bend * here.slope_x;
    y -= path * shot.bend * here.slope_y;
  }
  constexpr float kScale = kCausticCells / kCausticTile_m;
  const Float u = (x + shot.texture_x) * kScale, v = (y + shot.texture_y) * kScale;
  const Int i0 = floor_int(u), j0 = floor_int(v);
  const Float fu = u - to_float(i0), fv = v - to_float(j0);
  const Int wrap = Int{} + (kCausticCells - 1);
  const Int i = i0 & wrap, i1 = (i0 + 1) & wrap, j = (j0 & wrap) * kCausticCells,
            j1 = ((j0 + 1) & wrap) * kCausticCells;
  const Float level = 1.44269504f * logarithm(max(path * (1 / kCausticFirst_m), splat(1)));
  const Float bounded = clamp(level, 0, kCausticLevels - 1.001f);
  const Int lower = to_int(bounded);
  const Float between = bounded - to_float(lower);
  const auto sheet = [&](int above) {
    const float* cells = shot.caustics + above;
    const auto cell = [&](Int index) { return gather(cells, index * kCausticLevels + lower); };
    return mix(mix(cell(j + i), cell(j + i1), fu), mix(cell(j1 + i), cell(j1 + i1), fu), fv);
  };
  const Float light = mix(sheet(0), sheet(1), between);
  // Above the first level the pattern has not formed yet.
  return swell * mix(splat(1), light, clamp(path * (1 / kCausticFirst_m), 0, 1));
}

UWSIM_LANES Vector reflected_share(const Block& block) {
  return load(block.albedo) * load(block.through) * splat(1 / kPi);
}

/// Daylight on surfaces: the sky's at once, the sun's as a light under test. Level ground gets beam and sky by Kd;
/// slopes by their cosine to the sun and by how much sky and how much upwelling light they see.
void light_by_day(const Shot& shot, Block& block) {
  paint(shot, block);
  const Vector point = load(block.point), normal = load(block.normal);
  const Int lit = load(block.lit.at);
  const Float height = point.z + shot.camera_z;
  const Float surface = waves_at(shot, point.x, point.y).height;
  const Int under = shot.has_depth_light ? height < surface : Int{};
  const Float depth = surface - height;
  const DayAt day = day_at(shot, depth);
  const Float facing_up = 0.5f + 0.5f * normal.z;
  const Float day_cosine = max(dot(normal, spread(shot.to_sun)), Float{});
  const Float wet_cosine = max(dot(normal, spread(shot.to_sun_wet)), Float{}) * (1 / shot.to_sun_wet[2]);
  const Vector below = (day.total - day.beam) * facing_up + spread(shot.upwelling) * day.total * (1 - facing_up);
  // In air, what lies around throws back 0.15 of the daylight: assumed.
  const Vector level = spread(shot.beam) * splat(shot.to_sun[2] > 0 ? shot.to_sun[2] : 0.0f) + spread(shot.sky);
  const Vector in_air = spread(shot.sky) * facing_up + level * (0.15f * (1 - facing_up));
  const Vector share = reflected_share(block);
  const Vector light = load(block.light);
  store(block.light, select(lit, light + share * select(under, below, in_air), light));
  Vector wet_beam = day.beam * wet_cosine;
  if (shot.has_caustics && any(lit & under)) wet_beam = wet_beam * caustic_at(shot, point);
  const Vector beam = share * select(under, wet_beam, spread(shot.beam) * day_cosine);
  store(block.share, beam);
  const Vector to_sun = select(under, spread(shot.to_sun_wet), spread(shot.to_sun));
  store(block.to_light, to_sun);
  store(block.light_distance.at,
        select(under, max(depth, Float{}) * (1 / shot.to_sun_wet[2]) + kShadowReach_m, splat(3000.0f)));
  const Float worth = beam.x + beam.y + beam.z;
  const Float around = light.x + light.y + light.z;
  store(block.wants.at, lit & (worth > kWorthAShadow * around) & (worth > 1e-9f));
}

/// A lamp on surfaces, as a light under test: intensity / distance^2, dimmed by the water on the way.
void light_by_lamp(const Shot& shot, int index, Block& block) {
  const LampLight& lamp = shot.lamps[index];
  const Vector point = load(block.point), normal = load(block.normal);
  const Vector to_lamp = spread(lamp.position) - point;
  const Float square = max(dot(to_lamp, to_lamp), splat(1e-4f));
  const Float distance = square_root(square);
  const Vector way = to_lamp * (1 / distance);
  const Float cone = -dot(way, spread(lamp.axis));
  const Int lit = load(block.lit.at) & (cone > lamp.cos_outer);
  store(block.wants.at, lit);
  if (!any(lit)) return;
  const Float spot = smooth((cone - lamp.cos_outer) * (1 / (lamp.cos_inner - lamp.cos_outer)));
  const Float cosine = max(dot(normal, way), Float{});
  Vector light = spread(lamp.intensity) * (spot * cosine / square);
  if (shot.has_attenuation) light = light * exponential(spread(shot.c) * (-distance));
  light = reflected_share(block) * light;
  store(block.share, light);
  store(block.to_light, way);
  store(block.light_distance.at, distance - 0.02f);
  const Vector seen = load(block.light);
  const Float worth = light.x + light.y + light.z;
  store(block.wants.at, lit & (worth > kWorthAShadow * (seen.x + seen.y + seen.z)) & (worth > 1e-9f));
}

/// The light under test, where nothing is in its way.
void add_light(const Shot&, const Mask& blocked, Block& block) {
  const Int reaches = load(block.wants.at) & ~load(blocked.at);
  const Vector light = load(block.light);
  store(block.light, select(reaches, light + load(block.share), light));
}

}  // namespace
}  // namespace uwsim::camera
