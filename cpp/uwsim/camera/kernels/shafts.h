#pragma once

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

/// Weights of bilinear interpolation between blocks: the weights, for each lane, of the blocks before, at and after its
/// own along each axis. A block's value belongs to its middle, 1.5 pixels from its first pixel.
struct BlockWeights {
  alignas(64) float across[3][kLanes], down[3][kLanes];
};
constexpr BlockWeights block_weights() {
  BlockWeights weights{};
  for (int k = 0; k < kLanes; ++k) {
    const float x = static_cast<float>(k % kBlockSide) / kBlockSide - 0.375f;
    const float y = static_cast<float>(k / kBlockSide) / kBlockSide - 0.375f;
    weights.across[0][k] = x < 0 ? -x : 0, weights.across[1][k] = 1 - (x < 0 ? -x : x),
    weights.across[2][k] = x < 0 ? 0 : x;
    weights.down[0][k] = y < 0 ? -y : 0, weights.down[1][k] = 1 - (y < 0 ? -y : y), weights.down[2][k] = y < 0 ? 0 : y;
  }
  return weights;
}
constexpr BlockWeights kBlockWeights = block_weights();

/// The illumination of the water along each pixel's ray, interpolated between blocks: 1 without shafts, less in shadow,
/// more where light is focused.
UWSIM_LANES Float shaft_at(const View& view, int left, int top) {
  const int height = (view.height + kBlockSide - 1) / kBlockSide;
  const int i = left / kBlockSide, j = top / kBlockSide;
  const int i0 = i > 0 ? i - 1 : 0, i2 = i + 1 < view.shaft_width ? i + 1 : i;
  Float light;
  for (int n = 0; n < 3; ++n) {
    const int y = j + n - 1 < 0 ? 0 : (j + n - 1 < height ? j + n - 1 : height - 1);
    const float* row = view.shafts + y * view.shaft_width;
    const Float here = load(kBlockWeights.across[0]) * row[i0] + load(kBlockWeights.across[1]) * row[i] +
                       load(kBlockWeights.across[2]) * row[i2];
    light = light + load(kBlockWeights.down[n]) * here;
  }
  return light;
}

}  // namespace
}  // namespace uwsim::camera
