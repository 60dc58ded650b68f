#pragma once

#include <cstdint>
#include <span>

#include "uwsim/camera/camera.h"
#include "uwsim/camera/camera_scene.h"
#include "uwsim/camera/optics.h"
#include "uwsim/camera/picture.h"
#include "uwsim/camera/picture_request.h"

namespace uwsim {

/// Renders a camera's view. The model, per band, is that of Akkaynak and Treibitz 2018 ("A revised underwater image
/// formation model", CVPR) in its single-scattering form: L = L_surface exp(-c r) + backscatter, with the backscatter
/// of daylight by Kd (kernels/scattering.h) and that of lamps by a separate integral (kernels/lamps.h). Surfaces are
/// Lambertian. Valid where light is scattered once on its way to the camera; blur by forward scattering and light
/// reflected between surfaces are not modelled. Water and its effects end at the edge of the world's surface; a path is
/// followed through the water's surface once. The bytes do not depend on the number of threads. Throws InvalidValue if
/// the camera is below the ground; inside another solid, it sees the inside of that solid.
Picture render(const CameraScene& scene, const Camera& camera, const Optics& optics, const PictureRequest& request);

/// One of several pictures; without a scene, it is black.
struct PictureJob {
  const CameraScene* scene = nullptr;
  const Camera* camera = nullptr;
  const Optics* optics = nullptr;
  PictureRequest request;
};

/// Renders the colours of several pictures, each on one thread: those that `render` returns, one after the other in
/// `rgb`. The cameras have the same size, width x height. If some fail, the others are rendered; then throws
/// InvalidValue for the first that failed, naming it as batch[3].
void render_colours(std::span<PictureJob> jobs, int threads, std::span<std::uint8_t> rgb);

}  // namespace uwsim
