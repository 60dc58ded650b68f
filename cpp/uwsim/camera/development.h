#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "uwsim/camera/camera.h"
#include "uwsim/camera/kernels/kernels.h"
#include "uwsim/camera/picture_request.h"

namespace uwsim {

/// The factor from radiance to exposed signal. Automatic exposure brings the squared mean of the square roots of the
/// pixels' luminance to middle grey; neither darkness nor a lamp's glare dominates this mean. `root_luminance`: sums
/// over parts of the picture.
double exposure_gain(const ImageSensor& sensor, const Effects& effects, const std::vector<double>& root_luminance,
                     std::size_t pixels);

/// The parameters of develop_row for a given gain: amplification, vignetting and noise.
camera::Development development_of(const Camera& camera, const PictureRequest& request, std::uint64_t seed,
                                   double gain);

}  // namespace uwsim
