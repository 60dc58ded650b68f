#pragma once

#include <cstddef>

#include "uwsim/camera/kernels/block_lanes.h"
#include "uwsim/camera/kernels/view.h"

/// Conversion of pixels to camera rays. Included only by the kernels.
namespace uwsim::camera {
namespace {

/// Turbulent water bends rays: three waves across the picture that move over time. Their amplitude is derived from the
/// water (turbulence_bend_rad); their shape is a visual effect, not a measured model.
UWSIM_LANES void wobble(const View& view, Float& x, Float& y) {
  const float t = view.wobble_phase, a = view.wobble_rad;
  const Float first = sine(x * 23.0f + y * 11.0f + 2.1f * t), second = sine(y * 31.0f - x * 7.0f + 2.9f * t + 1.3f);
  const Float third = sine((x + y) * 47.0f - 4.3f * t + 0.7f);
  x += a * (first + 0.5f * third);
  y += a * (second - 0.5f * third);
}

UWSIM_LANES void set_rays(const View& view, Float x, Float y, Block& block) {
  if (view.wobble_rad > 0) wobble(view, x, y);
  const Vector ray = broadcast(view.right) * x + broadcast(view.down) * y + broadcast(view.ahead);
  store(block.direction, unit(ray));
  store(block.origin, zero());
}

/// Lane k is pixel (left + scale (k % 4), top + scale (k / 4)). Lanes beyond the picture's edge are inactive and repeat
/// the edge.
void rays_through_pixels(const View& view, int left, int top, int scale, Block& block) {
  Float x, y;
  for (int k = 0; k < kLanes; ++k) {
    const int u = left + scale * (k % kBlockSide), v = top + scale * (k / kBlockSide);
    block.active.at[k] = u < view.width && v < view.height ? -1 : 0;
    const int row = v < view.height ? v : view.height - 1, column = u < view.width ? u : view.width - 1;
    x[k] = view.ray_x[row * view.width + column];
    y[k] = view.ray_y[row * view.width + column];
  }
  set_rays(view, x, y, block);
}

/// Whether the whole block lies within the picture, as most blocks do: the rays of such blocks are tabulated block by
/// block.
UWSIM_LANES bool is_whole_block(const View& view, int left, int top) {
  return left + kBlockSide <= view.width && top + kBlockSide <= view.height;
}

void primary_rays(const View& view, int left, int top, Block& block) {
  if (!is_whole_block(view, left, top)) return rays_through_pixels(view, left, top, 1, block);
  const std::size_t columns = static_cast<std::size_t>(view.width) / kBlockSide;
  const std::size_t at = kBlockPixels * (static_cast<std::size_t>(top) / kBlockSide * columns + left / kBlockSide);
  // Between two blocks, ray traversal makes the hardware prefetcher lose track of the tables, so prefetch the next
  // block now.
  __builtin_prefetch(view.block_ray_x + at + kBlockPixels);
  __builtin_prefetch(view.block_ray_y + at + kBlockPixels);
  store(block.active.at, Int(-1));
  set_rays(view, load(view.block_ray_x + at), load(view.block_ray_y + at), block);
}

void shaft_rays(const View& view, int left, int top, int scale, Block& block) {
  rays_through_pixels(view, left, top, scale, block);
}

/// Initialises each path before its first segment: no light yet, and full throughput.
void start_paths(const View& view, Block& block) {
  store(block.throughput, ones());
  store(block.radiance, zero());
  store(block.sun_backscatter, zero());
  store(block.in_water.at, Int(view.camera_in_water ? -1 : 0));
}

}  // namespace
}  // namespace uwsim::camera
