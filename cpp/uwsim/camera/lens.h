#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

namespace uwsim {

/// A flat window between an air-filled housing and the water, across the optical axis. A ray at the angle a to the axis
/// in air is at the angle w in water, sin a = n sin w (Snell), and is displaced on its way through the glass. Rays in
/// water therefore do not meet at one point, and the magnification grows with the angle, so no distortion model of a
/// central camera is exact (Treibitz, Schechner, Kunz and Singh 2012, "Flat Refractive Geometry", IEEE TPAMI 34:51;
/// Jordt-Sedlazeck and Koch 2012, "Refractive Calibration of Underwater Cameras", ECCV).
struct FlatPort {
  double distance_m = 0;           ///< from the lens's centre of projection to the inside of the glass
  double thickness_m = 0;          ///< of the glass
  double refractive_index = 1.49;  ///< of the glass; acrylic

  /// Throws InvalidValue naming the field.
  void check() const;
};

/// A camera's geometry, as in OpenCV and sensor_msgs/CameraInfo: optical frame x right, y down, z ahead; pixel centres
/// have integer coordinates. Distortion follows Brown and Conrady ("plumb_bob"; Brown 1971, "Close-range camera
/// calibration"), with OpenCV's rational factor ("rational_polynomial") if k4, k5 or k6 is not 0: with r^2 = x^2 + y^2
/// of the undistorted x = X/Z, y = Y/Z,
///   x' = x (1 + k1 r^2 + k2 r^4 + k3 r^6) / (1 + k4 r^2 + k5 r^4 + k6 r^6) + 2 p1 x y + p2 (r^2 + 2 x^2), y' likewise;
///   u = fx x' + cx, v = fy y' + cy.
/// An equidistant lens follows Kannala and Brandt (2006, "A generic camera model and calibration method for
/// conventional, wide-angle, and fish-eye lenses", IEEE TPAMI 28:1335; OpenCV's fisheye): with the angle a = atan r,
///   r' = a (1 + k1 a^2 + k2 a^4 + k3 a^6 + k4 a^8).
/// Without a port, the parameters describe the camera in its housing, and hold in water as in air: a dome centred on
/// the lens, or the central approximation of any other housing. With a flat port, they describe the lens in air.
struct Lens {
  int width = 640, height = 360;
  double fx = 400, fy = 400, cx = 319.5, cy = 179.5;  ///< [pixels]
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0;
  std::optional<FlatPort> port = std::nullopt;
  double k4 = 0, k5 = 0, k6 = 0;
  bool is_equidistant = false;

  /// Throws InvalidValue naming the field.
  void check() const;
};

inline constexpr int kLargestSide = 8192;
inline constexpr double kWidestRay = 57;  ///< the largest r of an equidistant lens, at 89 degrees to the axis

/// True if the lens shows a ray (x, y) where `project` has it: the distortion does not fold the image over there.
bool shows(const Lens& lens, const Eigen::Vector2d& ray);
/// Maps undistorted (x, y) to a pixel.
Eigen::Vector2d project(const Lens& lens, const Eigen::Vector2d& ray, bool distort = true);
/// Projects a point in water (x right, y down, z ahead of the lens's centre [m]) through the lens's flat port to a
/// pixel. Returns nullopt if the point is not beyond the glass.
std::optional<Eigen::Vector2d> project_through_port(const Lens& lens, const Eigen::Vector3d& point_m, bool distort);
/// From pixel to undistorted (x, y), by Newton's method to 1e-12. Returns nullopt for a pixel that no ray meets because
/// the distortion folds the image over.
std::optional<Eigen::Vector2d> unproject(const Lens& lens, const Eigen::Vector2d& pixel, bool distort = true);

/// The ray through each pixel's centre, row by row: undistorted x and y. In water behind a flat port, the offsets are
/// the point where the extended ray meets the plane z = 0; otherwise they are empty. A pixel that no ray meets
/// continues outwards, without distortion, from the outermost ray in its direction from the principal point.
struct RayTable {
  std::size_t folded = 0;  ///< the number of these pixels
  std::vector<float> x, y, offset_x_m, offset_y_m;
  /// The same for each whole block of 4 x 4 pixels, sixteen values each; incomplete blocks at the edges are omitted.
  std::vector<float> block_x, block_y, block_offset_x_m, block_offset_y_m;
};
RayTable ray_table(const Lens& lens, bool distort, bool through_port = false);

}  // namespace uwsim
