#pragma once

#include "uwsim/camera/kernels/block_weights.h"
#include "uwsim/camera/kernels/daylight.h"

/// Shafts of sunlight: sampled per block, interpolated per pixel. Included only by the kernels.
namespace uwsim::camera {
namespace {

constexpr float kShaftSharpness = 8;  // rays whose lengths differ by an eighth share half of their light

/// How much of a ray counts for shafts.
UWSIM_LANES Float shaft_reach(const View& view, Float reach) { return min(reach, splat(3 / view.c[1])); }

/// Places a sample point on each ray, at a given fraction of the length worth sampling, and a shadow ray from that
/// point to the sun. The fraction is the same for all rays, so that light focused by the surface is visible as shafts.
void shaft_sample_point(const View& view, float share, Block& block) {
  const Float t = shaft_reach(view, load(block.reach.at)) * share;
  const Vector point = load(block.origin) + load(block.direction) * t;
  const Float depth = max(view.surface_z - (point.z + view.camera_z), Float{});
  store(block.distance.at, t);
  store(block.point, point);
  store(block.shadow_from, point);
  store(block.to_light, broadcast(view.to_sun_in_water));
  store(block.light_distance.at, depth * (1 / view.to_sun_in_water[2]) + kShadowReach_m);
  store(block.needs_shadow_ray.at, load(block.active.at) & load(block.in_water.at));
}

/// Computes the weight of the light at the sample point, and the caustics there, whose contrast the water on the way to
/// the eye reduces by scattering.
void shaft_sample_light(const View& view, const Block& block, BlockFloats& weight, BlockFloats& caustic) {
  const Float t = load(block.distance.at);
  store(weight.at, exponential(t * (-view.c[1] + view.kb[1] * load(block.direction.z.at))));
  if (!view.has_caustics) return store(caustic.at, splat(1));
  store(caustic.at, mix(splat(1), caustic_at(view, load(block.point)), exponential(t * -view.beam_b)));
}

/// The illumination of the water along each pixel's ray, interpolated between blocks: 1 without shafts, less in shadow,
/// more where light is focused. A block's value belongs to its middle, 1.5 pixels from its first pixel, and counts for
/// rays that end about as far away (a joint bilateral filter, Kopf et al. 2007, ACM Trans. Graph. 26:96).
UWSIM_LANES Float shaft_at(const View& view, int left, int top, Float reach) {
  static constexpr BlockWeights kWeights = block_weights(1.5f);
  const BlockNeighbours at(view, left, top);
  const Float own = shaft_reach(view, reach);
  float least = view.shaft_reach[at.rows[1] + at.columns[1]], most = least;
  for (const int row : at.rows) {
    for (const int column : at.columns) {
      const float end = view.shaft_reach[row + column];
      least = end < least ? end : least, most = end > most ? end : most;
    }
  }
  constexpr float kAlike = 0.5f / kShaftSharpness;  // weights differ by at most a sixteenth
  if (most - least < kAlike * least && !any(abs(own - least) > kAlike * least)) {
    return interpolate_blocks(kWeights, at, view.shafts);
  }
  const Float per_m = kShaftSharpness / max(own, splat(0.1f));
  Float sum{}, whole{};
  for (int n = 0; n < 3; ++n) {
    for (int m = 0; m < 3; ++m) {
      const int block = at.rows[n] + at.columns[m];
      const Float apart = (own - view.shaft_reach[block]) * per_m;
      const Float weight =
          (load(kWeights.down[n]) * load(kWeights.across[m]) + 1e-3f) / (1 + apart * apart * apart * apart);
      sum = sum + weight * view.shafts[block];
      whole = whole + weight;
    }
  }
  return sum / whole;
}

}  // namespace
}  // namespace uwsim::camera
