#pragma once

#include "uwsim/camera/kernels/caustics.h"
#include "uwsim/camera/kernels/gloss.h"
#include "uwsim/camera/kernels/materials.h"

/// Daylight on surfaces, and the addition of light that passes its shadow test. Included only by the kernels.
namespace uwsim::camera {
namespace {

constexpr float kShadowReach_m = 5.0f;     // above the water; anything higher casts no shadow into it
constexpr float kStrongestCaustic = 9.0f;  // caustic_at returns at most this

/// Shadow rays start slightly off the surface, on the eye's side: the smooth one, which the facets of a round body
/// would otherwise darken. The distance is infinite where nothing is hit.
UWSIM_LANES Vector shadow_start(const Block& block, Vector point, Vector normal) {
  return point + normal * (1e-3f + 2e-5f * min(load(block.distance.at), splat(1e5f)) + load(block.rise.at));
}

/// Returns true if light adds more than View::untested_share to the radiance so far, summed over the bands.
UWSIM_LANES Int matters(const View& view, Vector light, Vector so_far) {
  return light.x + light.y + light.z > view.untested_share * (so_far.x + so_far.y + so_far.z);
}

/// Adds light in `lit` lanes: at once where it does not matter whether it is blocked, elsewhere after a shadow test.
UWSIM_LANES void add_or_test(const View& view, Int lit, Vector light, Block& block) {
  const Vector so_far = load(block.radiance);
  const Int tested = lit & matters(view, light, so_far);
  store(block.unshadowed, light);
  store(block.needs_shadow_ray.at, tested);
  store(block.radiance, select(lit & ~tested, so_far + light, so_far));
}

/// Shades surfaces by daylight: the sky's light is added immediately; the sun's light is added later, if a shadow ray
/// is not blocked. Level ground receives beam and sky by Kd; slopes receive light according to the cosine of their
/// angle to the sun and to the sky and upwelling light that they face.
void shade_daylight(const View& view, Block& block) {
  apply_material(view, block);
  const Vector point = load(block.point), normal = load(block.normal);
  store(block.shadow_from, shadow_start(block, point, normal));
  const Int lit = load(block.lit.at);
  const Float height = point.z + view.camera_z;
  const Float surface = waves_at(view, point.x, point.y).height;
  const Int under = view.has_sunlight ? height < surface : Int{};
  const Float depth = surface - height;
  const DaylightAtDepth day = daylight_at_depth(view, depth);
  const Float facing_up = 0.5f + 0.5f * normal.z;
  const Float cosine_in_air = max(dot(normal, broadcast(view.to_sun)), Float{});
  const Float cosine_in_water =
      max(dot(normal, broadcast(view.to_sun_in_water)), Float{}) * (1 / view.to_sun_in_water[2]);
  const Vector in_water = (day.total - day.beam) * facing_up + broadcast(view.upwelling) * day.total * (1 - facing_up);
  // In air, the surroundings are assumed to reflect 0.15 of the daylight.
  const Vector on_level =
      broadcast(view.beam) * splat(view.to_sun[2] > 0 ? view.to_sun[2] : 0.0f) + broadcast(view.sky);
  const Vector in_air = broadcast(view.sky) * facing_up + on_level * (0.15f * (1 - facing_up));
  const Vector reflected = reflected_per_irradiance(block);
  const Vector before = load(block.radiance);
  const Vector so_far = select(lit, before + reflected * select(under, in_water, in_air), before);
  store(block.radiance, so_far);
  const Vector to_sun = select(under, broadcast(view.to_sun_in_water), broadcast(view.to_sun));
  Vector beam = reflected_from(view, block, normal, to_sun, under) *
                select(under, day.beam * cosine_in_water, broadcast(view.beam) * cosine_in_air);
  if (view.has_caustics && any(lit & under & matters(view, beam * splat(kStrongestCaustic), so_far))) {
    beam = beam * select(under, caustic_at(view, point), splat(1));
  }
  store(block.to_light, to_sun);
  store(block.light_distance.at,
        select(under, max(depth, Float{}) * (1 / view.to_sun_in_water[2]) + kShadowReach_m, splat(3000.0f)));
  add_or_test(view, lit, beam, block);
}

/// Adds the light being tested in lanes whose shadow ray was not blocked.
void add_unblocked_light(const View&, const BlockMask& blocked, Block& block) {
  const Int reaches = load(block.needs_shadow_ray.at) & ~load(blocked.at);
  const Vector light = load(block.radiance);
  store(block.radiance, select(reaches, light + load(block.unshadowed), light));
}

}  // namespace
}  // namespace uwsim::camera
