#pragma once

#include <span>
#include <vector>

#include "uwsim/core/pose.h"
#include "uwsim/world/ray_scene.h"

namespace uwsim {

/// A pinhole camera that sees depth. It looks along its frame's +x, y to the left, z up.
struct DepthCamera {
  int width = 0, height = 0;  ///< pixels
  double horizontal_fov_rad = 0, vertical_fov_rad = 0;
  double range_max_m = 0;  ///< the far plane: deeper is not seen
  int depth_bits = 0;      ///< depths as whole steps of range_max / (2^bits - 1), as a texture holds them; 0: floats

  void check() const;
};

/// depth_m[row * width + column] along the optical axis, the first row at the top, the first column to the left;
/// infinity where nothing is seen before the far plane, or only above the water (z = 0).
struct DepthImage {
  DepthCamera camera;
  std::vector<float> depth_m;
};

enum class RowReduction {
  kMiddle,   ///< the row that the level plane passes through, the upper of two that share it
  kNearest,  ///< the nearest of all rows: the first echo within the camera's height
};

/// One ray a pixel, through its middle, in the same scene as every sonar's.
DepthImage depth_image(const DepthCamera& camera, const RayScene& scene, const Pose& world_from_camera,
                       int threads = 1);

/// The depth-map method: a sonar's ranges from a depth image, as simulators on game engines make them. For each angle
/// about +z (positive to port) the image's column at that angle is reduced to one row, and depth becomes range by
/// 1 / cos(angle) (and, for kNearest, by the row's slope). `interpolate` weighs two neighbouring columns' inverse
/// depths, which is exact on a plane, where neither is empty and they differ by less than a tenth; else the nearest
/// pixel counts, which errs by up to half a pixel's angle times the bottom's dR/dangle.
/// Infinity where there is no depth, the range reaches range_max_m, or the angle is out of sight.
std::vector<float> depth_image_ranges(const DepthImage& image, std::span<const double> angles_rad,
                                      RowReduction reduction, bool interpolate);

}  // namespace uwsim
