#pragma once

#include <vector>

#include "uwsim/camera/kernel.h"
#include "uwsim/camera/tracer.h"

namespace uwsim {

/// Shafts of sunlight, a value for each block of 4 x 4 pixels: how much of the sun's beam, over its mean, lights the
/// water along the ray through the block's middle; 0 in full shadow, above 1 where ripples bundle it. Eight points a
/// ray, then smoothed over neighbours. Four blocks share what is cast: where the way ends, and its points' shadows.
std::vector<float> cast_shafts(const camera::Shot& shot, const Tracer& tracer, const camera::Kernels& kernels,
                               const Exposure& exposure, std::vector<PictureCost>& costs);

}  // namespace uwsim
