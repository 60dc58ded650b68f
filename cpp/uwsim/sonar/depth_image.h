#pragma once

#include <span>
#include <vector>

#include "uwsim/core/pose.h"
#include "uwsim/rays/ray_scene.h"

namespace uwsim {

/// A pinhole camera that renders depth. It looks along its frame's +x axis, with y to the left and z up.
struct DepthCamera {
  int width = 0, height = 0;  ///< pixels
  double horizontal_fov_rad = 0, vertical_fov_rad = 0;
  double range_max_m = 0;  ///< depth of the far plane
  int depth_bits = 0;      ///< quantised to range_max / (2^bits - 1), as in a texture; 0 for unquantised floats

  /// Throws InvalidValue naming camera.<field>.
  void check() const;
};

/// Depths along the optical axis, depth_m[row * width + column], with the first row at the top and the first column on
/// the left. Infinity if there is nothing in front of the far plane, or only surfaces above the water (z = 0).
struct DepthImage {
  DepthCamera camera;
  std::vector<float> depth_m;
};

enum class RowReduction {
  kMiddle,   ///< the row in the level plane; if there are two middle rows, the upper one
  kNearest,  ///< the nearest pixel in the column: the first echo within the vertical field of view
};

/// Casts one ray through the centre of each pixel. Throws InvalidValue.
DepthImage depth_image(const DepthCamera& camera, const RayScene& scene, const Pose& world_from_camera,
                       int threads = 1);

/// The depth-map method: computes a sonar's ranges from a depth image, as in simulators based on game engines. For each
/// angle about +z (positive to port), the image column at that angle is reduced to one depth, which is converted to
/// range by 1 / cos(angle) (for kNearest, also by the row's slope). `interpolate`: if two neighbouring columns are
/// non-empty and differ by less than a tenth, interpolates their inverse depths, which is exact on a plane; otherwise
/// the nearest pixel is used, with an error of up to half a pixel's angle times the bottom's dR/dangle. Infinity where
/// there is no depth, the range reaches range_max_m, or the angle is outside the field of view.
std::vector<float> depth_image_ranges(const DepthImage& image, std::span<const double> angles_rad,
                                      RowReduction reduction, bool interpolate);

}  // namespace uwsim
