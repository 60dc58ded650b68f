#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "uwsim/camera/camera.h"
#include "uwsim/camera/refraction.h"
#include "uwsim/core/check.h"

namespace uwsim {
namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180;

Lens lens_behind(const FlatPort& port) {
  Lens lens;
  lens.width = 801, lens.height = 601;
  lens.fx = lens.fy = 400, lens.cx = 400, lens.cy = 300;
  lens.port = port;
  return lens;
}

/// Where the ray from the lens's centre along (x, y, 1) in air is at depth z, by Snell's law at both faces.
Eigen::Vector3d traced(const FlatPort& port, const Eigen::Vector2d& slope, double z_m) {
  const Eigen::Vector3d towards_lens = -Eigen::Vector3d::UnitZ();
  const auto advanced = [](const Eigen::Vector3d& from, const Eigen::Vector3d& along, double to_z) {
    return Eigen::Vector3d(from + along * ((to_z - from.z()) / along.z()));
  };
  const Eigen::Vector3d air = Eigen::Vector3d(slope.x(), slope.y(), 1).normalized();
  const Eigen::Vector3d glass = *refracted(air, towards_lens, 1, port.refractive_index);
  const Eigen::Vector3d water = *refracted(glass, towards_lens, port.refractive_index, kWaterIndex);
  const Eigen::Vector3d inside = advanced(Eigen::Vector3d::Zero(), air, port.distance_m);
  return advanced(advanced(inside, glass, port.distance_m + port.thickness_m), water, z_m);
}

TEST(FlatPort, ARayAtThirtyDegreesLandsAt358PixelsAndBehindADomeAt231) {
  const Eigen::Vector3d point(std::tan(30 * kRadPerDeg), 0, 1);
  const Lens lens = lens_behind({});
  EXPECT_NEAR(project_through_port(lens, point, true)->x() - lens.cx, 357.6, 0.05);
  EXPECT_NEAR(project(lens, point.head<2>()).x() - lens.cx, 230.9, 0.05);
}

TEST(FlatPort, RaysFollowSnellsLawThroughBothFaces) {
  const FlatPort port{0.02, 0.015, 1.49};
  Lens lens = lens_behind(port);
  lens.k1 = -0.05, lens.p1 = 1e-3;
  const Camera camera("c", lens, {});
  const RayTable &water = camera.rays(true, true), &air = camera.rays(true, false);
  ASSERT_TRUE(air.offset_x_m.empty());
  for (std::size_t at = 0; at < water.x.size(); at += 997) {
    for (const double z : {port.distance_m + port.thickness_m, 0.5, 8.0}) {
      const Eigen::Vector3d expected = traced(port, {air.x[at], air.y[at]}, z);
      EXPECT_NEAR(water.offset_x_m[at] + z * water.x[at], expected.x(), 1e-6 * (1 + z));
      EXPECT_NEAR(water.offset_y_m[at] + z * water.y[at], expected.y(), 1e-6 * (1 + z));
    }
  }
  EXPECT_EQ(camera.rays(false, true).x, camera.rays(false, false).x) << "the port belongs to the lens";
}

TEST(FlatPort, APointIsProjectedToThePixelWhoseRayMeetsIt) {
  const FlatPort port{0.05, 0.01, 1.52};
  const Lens lens = lens_behind(port);
  for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(400, 300), Eigen::Vector2d(0, 0), Eigen::Vector2d(723, 41)}) {
    const Eigen::Vector2d slope = *unproject(lens, pixel);
    for (const double z : {0.0601, 0.3, 20.0}) {
      EXPECT_LT((*project_through_port(lens, traced(port, slope, z), true) - pixel).norm(), 1e-8) << z;
    }
  }
  EXPECT_FALSE(project_through_port(lens, {0, 0, 0.06}, true)) << "it is in the glass";
}

TEST(FlatPort, InvalidOnesAreRefused) {
  EXPECT_THROW(Camera("c", lens_behind({-0.1, 0, 1.5}), {}), InvalidValue);
  EXPECT_THROW(Camera("c", lens_behind({0, 2, 1.5}), {}), InvalidValue);
  EXPECT_THROW(Camera("c", lens_behind({0, 0, 0.9}), {}), InvalidValue);
}

}  // namespace
}  // namespace uwsim
