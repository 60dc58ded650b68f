#pragma once

#include "uwsim/camera/kernels/scattering.h"

/// The sky, for rays in air that hit nothing. Included only by the kernels.
namespace uwsim::camera {
namespace {

/// Radiance of the clear sky: three times as bright at the horizon as overhead, with the sun and a glow around it. Its
/// irradiance on level ground is about View::sky. This is a visual effect, not a measured model.
UWSIM_LANES Vector sky_towards(const View& view, Vector direction) {
  const Float up = clamp(direction.z, 0, 1), low = 1 - up;
  const Float bright = 0.72f + 1.6f * low * low * low * low;
  const Float toward = max(dot(direction, broadcast(view.to_sun)), Float{});
  const Float t2 = toward * toward, t4 = t2 * t2, t16 = t4 * t4 * t4 * t4, t64 = t16 * t16 * t16 * t16;
  const Float disc = smoothstep((toward - 0.99985f) * 2e4f);
  const Vector haze = broadcast(view.sky) * (bright * (1 / kPi));
  return haze + broadcast(view.beam) * (0.03f * t16 + 0.25f * t64 * t64 + 60 * disc);
}

/// Adds the sky's light to rays in air that hit nothing.
void add_sky(const View& view, Block& block) {
  const Float distance = load(block.distance.at);
  const Int sees = load(block.active.at) & ~load(block.in_water.at) & (distance > 1e30f) & ~load(block.onward.at);
  if (!any(sees)) return;
  const Vector light = load(block.radiance);
  store(block.radiance, select(sees, light + load(block.throughput) * sky_towards(view, load(block.direction)), light));
}

}  // namespace
}  // namespace uwsim::camera
