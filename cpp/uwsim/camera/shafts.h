#pragma once

#include <vector>

#include "uwsim/camera/kernels/kernels.h"
#include "uwsim/camera/picture_request.h"
#include "uwsim/camera/tracer.h"

namespace uwsim {

/// Shafts of sunlight, one value for each block of 4 x 4 pixels: the sunlight along the ray through the block's middle,
/// relative to its mean; 0 in full shadow, above 1 where ripples focus it; and how far along that ray it counts.
struct ShaftImage {
  std::vector<float> light, reach_m;
};

/// Sampled at eight points per ray, then smoothed over neighbouring blocks whose rays end about as far away. Groups of
/// 2 x 2 blocks share the ends of their rays where these are alike, and shadow rays at their sample points, whose
/// answers are smoothed in the same way and interpolated: the edges of a shadow would otherwise be as many as the
/// points.
ShaftImage cast_shafts(const camera::View& view, const Tracer& tracer, const camera::Kernels& kernels,
                       const PictureRequest& request, int threads);

}  // namespace uwsim
