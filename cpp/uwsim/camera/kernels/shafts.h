#pragma once

#include "uwsim/camera/kernels/block_weights.h"
#include "uwsim/camera/kernels/daylight.h"

/// Shafts of sunlight: sampled per block, interpolated per pixel. Included only by the kernels.
namespace uwsim::camera {
namespace {

/// Places a sample point on each ray, at a given fraction of the length worth sampling, and a shadow ray from that
/// point to the sun. The fraction is the same for all rays, so that light focused by the surface is visible as shafts.
void shaft_sample_point(const View& view, float share, Block& block) {
  const Float t = min(load(block.reach.at), splat(3 / view.c[1])) * share;
  const Vector point = load(block.origin) + load(block.direction) * t;
  const Float depth = max(view.surface_z - (point.z + view.camera_z), Float{});
  store(block.distance.at, t);
  store(block.point, point);
  store(block.shadow_from, point);
  store(block.to_light, broadcast(view.to_sun_in_water));
  store(block.light_distance.at, depth * (1 / view.to_sun_in_water[2]) + kShadowReach_m);
  store(block.needs_shadow_ray.at, load(block.active.at) & load(block.in_water.at));
}

/// Computes the weight of the light at the sample point, and the caustics there.
void shaft_sample_light(const View& view, const Block& block, BlockFloats& weight, BlockFloats& caustic) {
  const Float t = load(block.distance.at);
  store(weight.at, exponential(t * (-view.c[1] + view.kb[1] * load(block.direction.z.at))));
  store(caustic.at, view.has_caustics ? caustic_at(view, load(block.point)) : splat(1));
}

/// The illumination of the water along each pixel's ray, interpolated between blocks: 1 without shafts, less in shadow,
/// more where light is focused. A block's value belongs to its middle, 1.5 pixels from its first pixel.
UWSIM_LANES Float shaft_at(const View& view, int left, int top) {
  static constexpr BlockWeights kWeights = block_weights(1.5f);
  return interpolate_blocks(kWeights, BlockNeighbours(view, left, top), view.shafts);
}

}  // namespace
}  // namespace uwsim::camera
