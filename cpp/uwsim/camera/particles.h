#pragma once

#include <span>
#include <vector>

#include "uwsim/camera/kernel.h"
#include "uwsim/camera/renderer.h"

namespace uwsim {

/// What drifts in the water near the camera: one speck at most in each cell of a lattice that moves with the flow at
/// the camera, placed by a hash of seed and cell, lit by daylight and lamps, blurred by nearness. Every four seconds
/// others come and fade in while the last fade out, so that a picture follows from its time alone in any flow. Sizes,
/// brightness and that time: assumed.
struct Speck {
  float u, v;      ///< pixel
  float depth_m;   ///< along the optical axis
  float radius;    ///< of its blurred image [pixels]
  float light[3];  ///< radiance at its middle
};
std::vector<Speck> specks(const CameraScene& scene, const Camera& camera, const Optics& optics,
                          const Exposure& exposure, const camera::Shot& shot);

/// Adds the specks that lie before the scene to rows [first, last) of the film.
void add_specks(const std::vector<Speck>& specks, std::span<const float> depth_m, const camera::Shot& shot, int first,
                int last, const camera::Film& film);

}  // namespace uwsim
