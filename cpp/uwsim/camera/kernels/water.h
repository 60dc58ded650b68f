#pragma once

#include "uwsim/camera/kernels/water_surface.h"

/// Effects of the water along one straight segment of a ray. Included only by the kernels.
namespace uwsim::camera {
namespace {

constexpr float kFarthest_m = 2e4f;
constexpr float kNegligible = 1e-3f;   // throughput below which a path is not continued
constexpr float kSightLengths = 8.6f;  // exp(-8.6) = 1.8e-4

/// How far along each ray a surface can be seen through water: beyond, less than 1 / 5000 of its light arrives, and all
/// but that fraction of the backscatter is nearer, so it is taken for open water. Rays in air and rays in clear water
/// reach kFarthest_m.
UWSIM_LANES Float sight_m(const View& view, Vector direction, Int in_water) {
  if (!view.has_attenuation) return splat(kFarthest_m);
  const Float up = max(direction.z, Float{});
  const auto rate = [&](int band) { return backscatter_rate(splat(view.c[band]), splat(view.kb[band]), up); };
  return select(in_water, min(kSightLengths / min(rate(0), min(rate(1), rate(2))), splat(kFarthest_m)),
                splat(kFarthest_m));
}

/// Limits rays that are cast only for their colours; a little farther than sight, so that rounding does not matter.
void limit_to_sight(const View& view, const Block& block, BlockFloats& far_m) {
  store(far_m.at, sight_m(view, load(block.direction), load(block.in_water.at)) * 1.001f);
}

/// Returns true if no light arrives through kFarthest_m of the water, over which backscatter saturates to the last bit.
UWSIM_LANES bool is_opaque(const View& view) {
  constexpr float kOpaque_per_m = 17 / (kSlowest * kFarthest_m);  // exp(-17) is less than a float's rounding of 1
  return view.has_attenuation && view.c[0] > kOpaque_per_m && view.c[1] > kOpaque_per_m && view.c[2] > kOpaque_per_m;
}

/// Daylight where the segments start, which the block keeps.
UWSIM_LANES DaylightAtDepth daylight_at_start(const View& view, Vector origin, Block& block) {
  const Float depth = view.surface_z - (origin.z + view.camera_z);
  if (any(~(depth == load(block.day_depth.at)))) {
    const DaylightAtDepth day = daylight_at_depth(view, depth);
    store(block.day_depth.at, depth);
    store(block.day_total, day.total);
    store(block.day_beam, day.beam);
  }
  return {load(block.day_total), load(block.day_beam)};
}

/// Ends each ray's segment at its hit or at the surface, adds the backscatter of the water along it, and attenuates the
/// light from beyond.
void apply_water(const View& view, Block& block) {
  const Vector origin = load(block.origin), direction = load(block.direction);
  const Float distance = load(block.distance.at);
  const Int active = load(block.active.at), in_water = load(block.in_water.at), wet = in_water & active;
  const Int hit = distance < sight_m(view, direction, in_water);
  Int crosses = Int{};
  Float end = select(hit, distance, splat(kFarthest_m));
  if (view.has_surface) {
    const Float height = origin.z + view.camera_z;
    const Int approaches = select(in_water, direction.z > 1e-4f, direction.z < -1e-4f);
    Float surface = splat(view.surface_z);
    Float reach = (surface - height) / select(approaches, direction.z, splat(1));
    for (int k = 0; view.waves.values != nullptr && k < 3; ++k) {
      surface = waves_at(view, origin.x + direction.x * reach, origin.y + direction.y * reach).height;
      reach = max((surface - height) / select(approaches, direction.z, splat(1)), Float{});
    }
    crosses = active & approaches & (reach >= 0) & (reach < end);
    end = select(crosses, reach, end);
  }
  Vector throughput = load(block.throughput), light = load(block.radiance);
  if (any(wet)) {
    const Vector before = throughput;
    const bool is_open = is_opaque(view) && !any(active & (end < kFarthest_m));
    if (view.has_attenuation) throughput = is_open ? zero() : throughput * transmission(view.c, end);
    throughput = select(wet, throughput, before);
    if (view.has_backscatter) {
      Vector diffuse, beam;
      daylight_backscatter(view, daylight_at_start(view, origin, block), direction, end, is_open, diffuse, beam);
      light = select(wet, light + before * diffuse, light);
      const Vector sunlit = select(wet, load(block.sun_backscatter) + before * beam, load(block.sun_backscatter));
      store(block.sun_backscatter, sunlit);
    }
  }
  const Float strongest = max(throughput.x, max(throughput.y, throughput.z));
  store(block.throughput, throughput);
  store(block.radiance, light);
  store(block.lit.at, active & hit & ~crosses & (strongest > 0.2f * kNegligible));
  store(block.onward.at, crosses & (strongest > kNegligible));
  store(block.reach.at, end);
}

}  // namespace
}  // namespace uwsim::camera
