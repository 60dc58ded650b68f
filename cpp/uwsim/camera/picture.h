#pragma once

#include <cstdint>
#include <vector>

#include "uwsim/core/image_buffer.h"

namespace uwsim {

/// A rendered picture, rows from the top: width x height values, times 3 where noted, all from one pass. Depth,
/// normals, labels and classes are those of the first solid on each pixel's straight ray, after distortion and wobble,
/// as if the water and its surface were perfectly clear; colour follows the light through the surface.
struct Picture {
  int width = 0, height = 0;
  ImageBuffer<std::uint8_t> rgb;      ///< x 3, sRGB; empty if only geometry was requested
  std::vector<float> radiance;        ///< x 3, before exposure, if requested: irradiance as in daylight.h, per sr
  ImageBuffer<float> depth_m;         ///< along the optical axis (REP 118); infinity if nothing is hit
  ImageBuffer<float> normals_world;   ///< x 3, unit, towards the front of the triangle's winding; 0 if nothing is hit
  ImageBuffer<std::uint16_t> labels;  ///< see CameraScene::label_names
  ImageBuffer<std::uint8_t> classes;  ///< see SurfaceClass
  double gain = 0;                    ///< factor from radiance to exposed signal
};

}  // namespace uwsim
