#pragma once

#include <Eigen/Core>
#include <vector>

namespace uwsim {

/// A camera's geometry, as in OpenCV and sensor_msgs/CameraInfo: optical frame x right, y down, z ahead; pixel centres
/// have integer coordinates. Distortion follows Brown and Conrady ("plumb_bob"; Brown 1971, "Close-range camera
/// calibration"): with r^2 = x^2 + y^2 of the undistorted x = X/Z, y = Y/Z,
///   x' = x (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 x y + p2 (r^2 + 2 x^2), y' likewise; u = fx x' + cx, v = fy y' + cy.
/// Under water, the parameters must be those of the housed camera in water: refraction at a flat port is not modelled.
struct Lens {
  int width = 640, height = 360;
  double fx = 400, fy = 400, cx = 319.5, cy = 179.5;  ///< [pixels]
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0;

  /// Throws InvalidValue naming the field, also if the distortion folds the image over itself.
  void check() const;
};

inline constexpr int kLargestSide = 8192;

/// Maps undistorted (x, y) to a pixel.
Eigen::Vector2d project(const Lens& lens, const Eigen::Vector2d& ray, bool distort = true);
/// Maps a pixel to undistorted (x, y), by Newton's method to 1e-12. Throws InvalidValue if it does not converge.
Eigen::Vector2d unproject(const Lens& lens, const Eigen::Vector2d& pixel, bool distort = true);

/// Undistorted x and y of each pixel's centre, in row-major order.
struct RayTable {
  std::vector<float> x, y;
  /// The same for each whole block of 4 x 4 pixels, sixteen values each; incomplete blocks at the edges are omitted.
  std::vector<float> block_x, block_y;
};
RayTable ray_table(const Lens& lens, bool distort);

}  // namespace uwsim
