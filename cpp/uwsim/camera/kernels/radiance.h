#pragma once

#include <cstddef>

#include "uwsim/camera/kernels/kernels.h"
#include "uwsim/camera/kernels/primary_rays.h"
#include "uwsim/camera/kernels/shafts.h"

/// Conversion of finished paths to the radiance image. Included only by the kernels.
namespace uwsim::camera {
namespace {

/// Luminance, weighted like sRGB's primaries.
UWSIM_LANES Float luminance(Vector light) { return light.x * 0.2126f + light.y * 0.7152f + light.z * 0.0722f; }

UWSIM_LANES void write_plane(const View& view, int left, int top, const float* light, float* plane) {
  const std::size_t first = static_cast<std::size_t>(top) * view.width + left;
  if (is_whole_block(view, left, top)) {
    for (int row = 0; row < kBlockSide; ++row) {
      __builtin_memcpy(plane + first + row * view.width, light + row * kBlockSide, kBlockSide * sizeof(float));
    }
    return;
  }
  for (int k = 0; k < kLanes; ++k) {
    const int u = k % kBlockSide, v = k / kBlockSide;
    if (left + u < view.width && top + v < view.height) plane[first + v * view.width + u] = light[k];
  }
}

/// Writes the light of finished paths, including shafts, and the square root of each pixel's luminance, for the
/// exposure.
void write_radiance(const View& view, int left, int top, const Block& block, const RadiancePlanes& planes,
                    BlockFloats& root_luminance) {
  Vector light = load(block.radiance);
  const Vector beam = load(block.sun_backscatter);
  light = light + (view.shaft_width > 0 ? beam * shaft_at(view, left, top, load(block.first_reach.at)) : beam);
  BlockVectors rows;
  store(rows, light);
  write_plane(view, left, top, rows.x.at, planes.red);
  write_plane(view, left, top, rows.y.at, planes.green);
  write_plane(view, left, top, rows.z.at, planes.blue);
  store(root_luminance.at, square_root(max(luminance(light), Float{})));
}

}  // namespace
}  // namespace uwsim::camera
