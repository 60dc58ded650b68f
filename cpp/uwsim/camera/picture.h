#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "uwsim/camera/kernels/block.h"
#include "uwsim/core/image_buffer.h"
#include "uwsim/rays/ray_packet.h"

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
  ImageBuffer<std::uint8_t> classes;  ///< see CameraScene::class_names
  ImageBuffer<std::uint32_t>
      pieces;       ///< numbers of pieces of cover and of fish, 0 elsewhere; empty in a world without both
  double gain = 0;  ///< factor from radiance to exposed signal

  /// Keeps the pieces that a block of pixels shows.
  void keep_pieces(int left, int top, const HitPacket& hits) {
    for (int row = top; row < std::min(height, top + camera::kBlockSide); ++row) {
      for (int column = left; column < std::min(width, left + camera::kBlockSide); ++column) {
        const int lane = (row - top) * camera::kBlockSide + column - left;
        pieces[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column)] =
            hits.piece[static_cast<std::size_t>(lane)];
      }
    }
  }
};

}  // namespace uwsim
