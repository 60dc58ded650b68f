#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "uwsim/camera/camera.h"
#include "uwsim/camera/camera_scene.h"
#include "uwsim/camera/kernels/kernels.h"
#include "uwsim/camera/optics.h"
#include "uwsim/camera/picture_request.h"

namespace uwsim {

/// A particle that drifts in the water near the camera. Each cell of a lattice that moves with the flow at the camera
/// contains at most one particle, placed by a hash of seed and cell, lit by daylight and lamps, and out of focus when
/// near. Every four seconds, a new generation fades in and the previous one fades out, so that a picture depends only
/// on its time, in any flow. Sizes, brightness and the interval are assumed.
struct Particle {
  float u, v;      ///< pixel
  float depth_m;   ///< along the optical axis
  float radius;    ///< of its defocused image [pixels]
  float light[3];  ///< radiance at the centre of its image
};

/// The particles that the camera can see; none if the camera is in air.
std::vector<Particle> visible_particles(const CameraScene& scene, const Camera& camera, const Optics& optics,
                                        const PictureRequest& request, const camera::View& view);

/// Adds the particles in front of the scene to rows [first, last) of the radiance.
void draw_particles(const std::vector<Particle>& particles, std::span<const float> depth_m, const camera::View& view,
                    int first, int last, const camera::RadiancePlanes& radiance);

}  // namespace uwsim
