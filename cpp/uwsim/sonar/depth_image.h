#pragma once

#include <span>
#include <vector>

#include "uwsim/core/pose.h"
#include "uwsim/rays/ray_scene.h"

namespace uwsim {

/// A pinhole camera that renders depth. It looks along its frame's +x, with y to the left and z up.
struct DepthCamera {
  int width = 0, height = 0;  ///< pixels
  double horizontal_fov_rad = 0, vertical_fov_rad = 0;
  double range_max_m = 0;  ///< depth of the far plane
  int depth_bits = 0;      ///< quantised to range_max / (2^bits - 1), as in a texture; 0: unquantised floats

  /// Throws InvalidValue that names camera.<field>.
  void check() const;
};

/// depth_m[row * width + column] along the optical axis, with the first row at the top and the first column on the
/// left; infinity if nothing lies before the far plane, or only surfaces above the water (z = 0).
struct DepthImage {
  DepthCamera camera;
  std::vector<float> depth_m;
};

enum class RowReduction {
  kMiddle,   ///< the row in the level plane; with two middle rows, the upper one
  kNearest,  ///< the nearest of all rows: the first echo within the vertical field of view
};

/// Casts one ray through the centre of each pixel. Throws InvalidValue.
DepthImage depth_image(const DepthCamera& camera, const RayScene& scene, const Pose& world_from_camera,
                       int threads = 1);

/// The depth-map method: ranges of a sonar from a depth image, as in simulators based on game engines. For each angle
/// about +z (positive to port) the image's column at that angle is reduced to one row, and depth is converted to range
/// by 1 / cos(angle) (for kNearest also by the row's slope). `interpolate`: interpolates the inverse depths of two
/// neighbouring columns, which is exact on a plane, if neither is empty and they differ by less than a tenth; otherwise
/// the nearest pixel is used, with an error of up to half a pixel's angle times the bottom's dR/dangle. Infinity where
/// there is no depth, the range reaches range_max_m, or the angle is outside the field of view.
std::vector<float> depth_image_ranges(const DepthImage& image, std::span<const double> angles_rad,
                                      RowReduction reduction, bool interpolate);

}  // namespace uwsim
