#pragma once

#include <span>
#include <vector>

#include "uwsim/camera/camera_scene.h"
#include "uwsim/camera/kernels/kernels.h"
#include "uwsim/camera/picture_request.h"

namespace uwsim {

/// The clouds that the picture shows, the farthest first.
std::vector<SedimentCloud> clouds_in_sight(const PictureRequest& request, const camera::View& view);

/// Adds the sediment in the water to a row of the radiance, and returns the change of the sum of the roots of its
/// luminance. A cloud takes exp(-tau) of what is behind it,
/// with the optical depth tau along the ray in closed form, and adds 1 - exp(-tau) of the light that a surface of the
/// bed's albedo sends back from where the cloud is densest. Nearer clouds are in front of farther ones as wholes; the
/// veil of the water in front of a cloud is dimmed with what is behind it, and clouds shade neither bed nor each other.
double draw_murk(const CameraScene& scene, const PictureRequest& request, std::span<const SedimentCloud> clouds,
                 std::span<const float> depth_m, const camera::View& view, int row,
                 const camera::RadiancePlanes& radiance);

}  // namespace uwsim
