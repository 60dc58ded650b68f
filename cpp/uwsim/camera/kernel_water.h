#pragma once

#include "uwsim/camera/kernel_geometry.h"

/// What water does along a ray, and what lies at its end when nothing solid does. Included by kernel_*.cpp only.
namespace uwsim::camera {
namespace {

constexpr float kFarthest_m = 2e4f;
constexpr float kUnseen = 1e-3f;  // of what arrives: less is not followed
constexpr float kPi = 3.14159265f;

/// Henyey and Greenstein 1941, [1/sr].
UWSIM_LANES Float forward_phase(Float cosine, float g) {
  const Float side = 1 + g * g - 2 * g * cosine;
  return splat((1 - g * g) / (4 * kPi)) / (side * square_root(max(side, splat(1e-6f))));
}
UWSIM_LANES Float molecule_phase(Float cosine) { return (3 / (16 * kPi)) * (1 + cosine * cosine); }

/// Light that water scatters towards the eye for each unit of irradiance, [1/(m sr)]. `g`: see kVeilAsymmetry.
UWSIM_LANES Vector scattered(const Shot& shot, Float cosine, float g) {
  const Float particles = forward_phase(cosine, g), molecules = molecule_phase(cosine);
  return spread(shot.particle_b) * particles + spread(shot.molecule_b) * molecules;
}
// Single scattering by real particles (g about 0.9) leaves the water beside the camera ten times too dark, since
// daylight is scattered many times. 0.5 gives horizontal radiance of some 0.04 of the downwelling irradiance in turbid
// water, as radiance distributions measured in lakes and seas have it: assumed, by its order of magnitude.
constexpr float kVeilAsymmetry = 0.5f;
// A lamp's light near the camera is scattered once: particles as a whole (Petzold 1972 by way of g = 0.9: assumed).
constexpr float kLampAsymmetry = 0.9f;

struct Sheet {
  Float height, slope_x, slope_y;
};

/// The world's waves at a place, between the window's nodes; at its edge, the edge's.
UWSIM_LANES Sheet waves_at(const Shot& shot, Float x, Float y) {
  const WaveWindow& window = shot.waves;
  if (window.cells == nullptr) return {splat(shot.surface_z), Float{}, Float{}};
  const float last = static_cast<float>(window.side - 1) - 0.001f;
  const Float u = clamp((x - window.left) / window.spacing, 0, last);
  const Float v = clamp((y - window.bottom) / window.spacing, 0, last);
  const Int i = to_int(u), j = to_int(v);
  const Float fu = u - to_float(i), fv = v - to_float(j);
  const Int at = 3 * (j * window.side + i), above = at + 3 * window.side;
  const auto value = [&](int field) {
    const float* cells = window.cells + field;
    return mix(mix(gather(cells, at), gather(cells, at + 3), fu),
               mix(gather(cells, above), gather(cells, above + 3), fu), fv);
  };
  return {value(0), value(1), value(2)};
}

UWSIM_LANES void add_ripples(const Shot& shot, Float x, Float y, Float distance, Sheet& sheet) {
  if (shot.slopes == nullptr) return;
  constexpr float kScale = kCausticCells / kCausticTile_m;
  const Float u = (x + shot.texture_x) * kScale, v = (y + shot.texture_y) * kScale;
  const Int i0 = floor_int(u), j0 = floor_int(v);
  const Float fu = u - to_float(i0), fv = v - to_float(j0);
  const Int wrap = Int{} + (kCausticCells - 1);
  const Int i = i0 & wrap, i1 = (i0 + 1) & wrap, j = (j0 & wrap) * kCausticCells,
            j1 = ((j0 + 1) & wrap) * kCausticCells;
  // From afar a pixel holds many ripples, whose slopes cancel.
  const Float nearness = 1 / (1 + distance * distance * (shot.pixel_rad * shot.pixel_rad * 40));
  const auto value = [&](int field) {
    const float* cells = shot.slopes + field;
    return nearness * mix(mix(gather(cells, 2 * (j + i)), gather(cells, 2 * (j + i1)), fu),
                          mix(gather(cells, 2 * (j1 + i)), gather(cells, 2 * (j1 + i1)), fu), fv);
  };
  sheet.slope_x += value(0);
  sheet.slope_y += value(1);
}

/// Irradiances at depths below the surface, by Kd; of the beam, which other scattering turns to the sky's kind.
struct DayAt {
  Vector total, beam;
};
UWSIM_LANES DayAt day_at(const Shot& shot, Float depth) {
  const Float d = max(depth, Float{});
  DayAt day;
  day.total = spread(shot.total_level) * exponential(spread(shot.kd) * (-d));
  day.beam = spread(shot.beam_level) * exponential(spread(shot.kb) * (-d));
  return day;
}

/// Clear sky: three times as bright at the horizon as overhead, with the sun and a glow around it; on level ground its
/// irradiance is about that of Shot::sky. A look, not a measured model.
UWSIM_LANES Vector sky_towards(const Shot& shot, Vector way) {
  const Float up = clamp(way.z, 0, 1), low = 1 - up;
  const Float bright = 0.72f + 1.6f * low * low * low * low;
  const Float toward = max(dot(way, spread(shot.to_sun)), Float{});
  const Float t2 = toward * toward, t4 = t2 * t2, t16 = t4 * t4 * t4 * t4, t64 = t16 * t16 * t16 * t16;
  const Float disc = smooth((toward - 0.99985f) * 2e4f);
  const Vector haze = spread(shot.sky) * (bright * (1 / kPi));
  return haze + spread(shot.beam) * (0.03f * t16 + 0.25f * t64 * t64 + 60 * disc);
}

/// Radiance that comes up out of deep water.
UWSIM_LANES Vector upwelling(const Shot& shot) {
  return spread(shot.upwelling) * spread(shot.total_level) * splat(1 / kPi);
}

/// Light scattered into a ray over `length` of water and dimmed on its way to the eye, in closed form: daylight changes
/// as exp(-K depth) along the ray, so that the veil is J / k (1 - exp(-k length)) with k = c - K sin(elevation); it
/// saturates, at J / c for a level ray. Split into what the sun's beam makes, which shafts modulate, and the rest.
UWSIM_LANES void add_veil(const Shot& shot, Vector origin, Vector way, Float length, Vector& calm, Vector& beam) {
  const Float depth = shot.surface_z - (origin.z + shot.camera_z);
  const DayAt day = day_at(shot, depth);
  const Vector c = spread(shot.c), kd = spread(shot.kd), kb = spread(shot.kb);
  const auto gained = [&](Float c1, Float k1) {
    const Float rate = max(c1 - k1 * way.z, 0.05f * c1 + 1e-6f);
    return (1 - exponential(-rate * length)) / rate;
  };
  const Vector total = {gained(c.x, kd.x), gained(c.y, kd.y), gained(c.z, kd.z)};
  const Vector direct = {gained(c.x, kb.x), gained(c.y, kb.y), gained(c.z, kb.z)};
  const Vector from_above = scattered(shot, way.z, kVeilAsymmetry);
  const Vector from_sun = scattered(shot, dot(way, spread(shot.to_sun_wet)), kVeilAsymmetry);
  beam = day.beam * direct * from_sun * splat(1 / shot.to_sun_wet[2]);
  calm = (day.total * total - day.beam * direct) * from_above;
  calm = {max(calm.x, Float{}), max(calm.y, Float{}), max(calm.z, Float{})};
}

/// Ends each ray at its hit or at the surface, adds the veil of its water and dims what follows.
void pass_water(const Shot& shot, Block& block) {
  const Vector origin = load(block.origin), way = load(block.direction);
  const Float distance = load(block.distance.at);
  const Int active = load(block.active.at), wet = load(block.wet.at);
  const Int hit = distance < 1e30f;
  Int crosses = Int{};
  Float end = min(distance, splat(kFarthest_m));
  if (shot.has_surface) {
    const Float height = origin.z + shot.camera_z;
    const Int towards = select(wet, way.z > 1e-4f, way.z < -1e-4f);
    Float surface = splat(shot.surface_z);
    Float reach = (surface - height) / select(towards, way.z, splat(1));
    for (int k = 0; shot.waves.cells != nullptr && k < 3; ++k) {
      surface = waves_at(shot, origin.x + way.x * reach, origin.y + way.y * reach).height;
      reach = max((surface - height) / select(towards, way.z, splat(1)), Float{});
    }
    crosses = active & towards & (reach >= 0) & (reach < end);
    end = select(crosses, reach, end);
  }
  Vector through = load(block.through), light = load(block.light);
  if (any(wet & active)) {
    const Vector seen = through;
    if (shot.has_attenuation) through = through * exponential(spread(shot.c) * (-end));
    through = select(wet, through, seen);
    if (shot.has_backscatter) {
      Vector calm, beam;
      add_veil(shot, origin, way, end, calm, beam);
      light = select(wet, light + seen * calm, light);
      const Vector sunlit = select(wet, load(block.veil_beam) + seen * beam, load(block.veil_beam));
      store(block.veil_beam, sunlit);
    }
  }
  const Float strongest = max(through.x, max(through.y, through.z));
  store(block.through, through);
  store(block.light, light);
  store(block.lit.at, active & hit & ~crosses & (strongest > 0.2f * kUnseen));
  store(block.onward.at, crosses & (strongest > kUnseen));
  store(block.reach.at, end);
}

/// Turns rays that came to the surface: the stronger of the refracted and the reflected way goes on, the other is taken
/// to see clear sky or deep water. Radiance changes by n^2 across the surface (Mobley 1994, "Light and Water", ch. 4).
void go_on(const Shot& shot, Block& block) {
  const Vector way = load(block.direction);
  const Float end = load(block.reach.at);
  const Vector at = load(block.origin) + way * end;
  const Int onward = load(block.onward.at), wet = load(block.wet.at);
  Sheet sheet = waves_at(shot, at.x, at.y);
  add_ripples(shot, at.x, at.y, end, sheet);
  const Vector up = unit({-sheet.slope_x, -sheet.slope_y, splat(1)});
  const Vector facing = select(wet, up * splat(-1), up);  // towards where the ray comes from
  const Float cosine = clamp(-dot(way, facing), 0.02f, 1);
  const Float ratio = select(wet, splat(shot.index), splat(1 / shot.index));
  const Float sine2 = ratio * ratio * (1 - cosine * cosine);
  const Int total = sine2 >= 1;
  const Float beyond = square_root(max(1 - sine2, Float{}));
  const Float s = (ratio * cosine - beyond) / (ratio * cosine + beyond);
  const Float p = (ratio * beyond - cosine) / (ratio * beyond + cosine);
  const Float reflectance = select(total, splat(1), 0.5f * (s * s + p * p));
  Vector bent = unit(way * ratio + facing * (ratio * cosine - beyond));
  Vector mirrored = unit(way + facing * (2 * cosine));
  // A ripple must not send a ray back through the surface it leaves.
  bent.z = select(wet, max(bent.z, splat(0.002f)), min(bent.z, splat(-0.002f)));
  mirrored.z = select(wet, min(mirrored.z, splat(-0.002f)), max(mirrored.z, splat(0.002f)));
  const Int mirrors = reflectance > 0.5f;
  const Float gain = select(wet, splat(shot.index * shot.index), splat(1 / (shot.index * shot.index)));
  const Float transmitted = (1 - reflectance) * gain;
  const Vector water = upwelling(shot);
  const Vector other = select(select(wet, mirrors, ~mirrors), sky_towards(shot, select(wet, bent, mirrored)), water);
  const Float other_share = select(mirrors, transmitted, reflectance);
  const Vector through = load(block.through), light = load(block.light);
  store(block.light, select(onward, light + through * other * select(total & mirrors, Float{}, other_share), light));
  store(block.through, through * select(mirrors, reflectance, transmitted));
  store(block.direction, select(mirrors, mirrored, bent));
  store(block.origin, {at.x, at.y, at.z});
  store(block.wet.at, select(mirrors, wet, ~wet));
  store(block.active.at, onward);
}

/// The sky for dry rays that met nothing.
void sky(const Shot& shot, Block& block) {
  const Float distance = load(block.distance.at);
  const Int sees = load(block.active.at) & ~load(block.wet.at) & (distance > 1e30f) & ~load(block.onward.at);
  if (!any(sees)) return;
  const Vector light = load(block.light);
  store(block.light, select(sees, light + load(block.through) * sky_towards(shot, load(block.direction)), light));
}

}  // namespace
}  // namespace uwsim::camera
