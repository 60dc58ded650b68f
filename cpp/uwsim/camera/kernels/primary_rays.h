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

/// The number of each lane's row in its block.
UWSIM_LANES Float lane_rows() {
  Float rows;
  for (int k = 0; k < kLanes; ++k) rows[k] = static_cast<float>(k / kBlockSide);
  return rows;
}

/// Moves rays to where the camera is when it exposes their rows.
UWSIM_LANES void move_rays(const View& view, Float row, Block& block) {
  const Float time = (row - 0.5f * static_cast<float>(view.height - 1)) * view.row_s + view.part_s;
  const Vector axis = broadcast(view.spin_axis);
  const SineCosine angle = sine_cosine_of_turns(time * view.spin_turns_per_s);
  const auto turned = [&](Vector v) {  // Rodrigues's formula
    return v * angle.cosine + cross(axis, v) * angle.sine + axis * (dot(axis, v) * (1 - angle.cosine));
  };
  store(block.direction, turned(load(block.direction)));
  store(block.origin, turned(load(block.origin)) + broadcast(view.velocity) * time);
}

/// Sets the rays of the rows from `top` on, `scale` rows apart. Their slopes to the optical axis are x and y; they
/// start at (offset_x, offset_y) in the plane across it.
UWSIM_LANES void set_rays(const View& view, int top, int scale, Float x, Float y, Float offset_x, Float offset_y,
                          Block& block) {
  if (view.wobble_rad > 0) wobble(view, x, y);
  const Vector right = broadcast(view.right), down = broadcast(view.down);
  store(block.direction, unit(right * x + down * y + broadcast(view.ahead)));
  store(block.origin, view.has_offsets ? right * offset_x + down * offset_y : zero());
  if (view.moves) move_rays(view, lane_rows() * static_cast<float>(scale) + static_cast<float>(top), block);
}

/// The values of a picture at every `scale`th pixel.
UWSIM_LANES Float sparse(const float* first, int width, int scale) {
  Float value;
  for (int k = 0; k < kLanes; ++k) value[k] = first[scale * (k / kBlockSide * width + k % kBlockSide)];
  return value;
}

/// Lane k is pixel (left + scale (k % 4), top + scale (k / 4)). Lanes beyond the picture's edge are inactive and repeat
/// the edge.
void rays_through_pixels(const View& view, int left, int top, int scale, Block& block) {
  Float x, y, offset_x{}, offset_y{};
  const int reach = scale * (kBlockSide - 1);
  if (left + reach < view.width && top + reach < view.height) {
    const int first = top * view.width + left;
    const auto values = [&](const float* picture) { return sparse(picture + first, view.width, scale); };
    if (view.has_offsets) offset_x = values(view.offset_x), offset_y = values(view.offset_y);
    store(block.active.at, Int(-1));
    return set_rays(view, top, scale, values(view.ray_x), values(view.ray_y), offset_x, offset_y, block);
  }
  for (int k = 0; k < kLanes; ++k) {
    const int u = left + scale * (k % kBlockSide), v = top + scale * (k / kBlockSide);
    block.active.at[k] = u < view.width && v < view.height ? -1 : 0;
    const int row = v < view.height ? v : view.height - 1, column = u < view.width ? u : view.width - 1;
    const int at = row * view.width + column;
    x[k] = view.ray_x[at];
    y[k] = view.ray_y[at];
    if (view.has_offsets) offset_x[k] = view.offset_x[at], offset_y[k] = view.offset_y[at];
  }
  set_rays(view, top, scale, x, y, offset_x, offset_y, block);
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
  Float offset_x{}, offset_y{};
  if (view.has_offsets) offset_x = load(view.block_offset_x + at), offset_y = load(view.block_offset_y + at);
  set_rays(view, top, 1, load(view.block_ray_x + at), load(view.block_ray_y + at), offset_x, offset_y, block);
}

void shaft_rays(const View& view, int left, int top, int scale, Block& block) {
  rays_through_pixels(view, left, top, scale, block);
}

/// A ray along d meets a box at t if low <= t d <= high along each axis: at least for one d between the limits.
bool may_meet(const BoxLanes& boxes, const float* from, const float* direction, float aside) {
  Float enters = load(boxes.least.at), leaves = splat(3e38f);
  const auto limit = [&](const BlockFloats& sides, int axis, float slope, bool is_entry) {
    const Float at = (load(sides.at) - from[axis]) * (1 / slope);
    is_entry ? enters = max(enters, at) : leaves = min(leaves, at);
  };
  const auto limit_both = [&](const BlockFloats& low, const BlockFloats& high, int axis) {
    const float most = direction[axis] + aside, least = direction[axis] - aside;
    limit(low, axis, most, most > 0), limit(high, axis, least, least < 0);
  };
  limit_both(boxes.low.x, boxes.high.x, 0);
  limit_both(boxes.low.y, boxes.high.y, 1);
  limit_both(boxes.low.z, boxes.high.z, 2);
  return any(enters <= leaves);
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
