#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "meshes.h"
#include "uwsim/camera/renderer.h"

namespace uwsim {
namespace {

constexpr double kWall_m = 4, kFocal = 120;

Camera watcher(double shutter_s, double readout_s) {
  Lens lens;
  lens.width = 160, lens.height = 120;
  lens.fx = lens.fy = kFocal, lens.cx = 79.5, lens.cy = 59.5;
  ImageSensor sensor;
  sensor.shutter_s = shutter_s, sensor.readout_s = readout_s;
  return Camera("c", lens, sensor);
}

/// A dry scene: the right half of the view is a wall, 4 m ahead; the left half is far away.
class Shutter : public ::testing::Test {
 protected:
  Shutter() {
    TriangleMesh wall = testing::box(0.06, 40, 40);
    for (Eigen::Vector3d& vertex : wall.vertices_m) vertex += Eigen::Vector3d(kWall_m + 0.03, -20, 0);
    world.add_solid("wall", wall);
  }

  Picture picture(const Camera& camera, const Vector6d& velocity, int threads = 1, RayRecord* record = nullptr) const {
    PictureRequest request;
    request.effects = Effects::none();
    request.effects.set(Effect::kShutter, true);
    request.velocity_camera = velocity;
    request.keep_radiance = true;
    request.threads = threads;
    request.record = record;
    Optics optics;
    optics.water = jerlov_water("III");
    return render(CameraScene(world, std::make_shared<RayScene>(world), 7), camera, optics, request);
  }

  World world;
};

/// The column at which a row's depth becomes finite.
double edge(const Picture& picture, int row) {
  for (int u = 0; u < picture.width; ++u) {
    if (std::isfinite(picture.depth_m[static_cast<std::size_t>(row * picture.width + u)])) return u;
  }
  return NAN;
}

TEST_F(Shutter, ARollingShutterSlantsAnEdgeByTheMotionBetweenRows) {
  Vector6d aside = Vector6d::Zero(), turning = Vector6d::Zero();
  aside(1) = 2;      // to port: the wall's edge moves to starboard in the picture
  turning(5) = 0.5;  // to port
  for (const auto& [velocity, pixels_per_s] :
       {std::pair(aside, kFocal * 2 / kWall_m), std::pair(turning, kFocal * 0.5)}) {
    const Picture still = picture(watcher(0, 0.2), Vector6d::Zero()), moved = picture(watcher(0, 0.2), velocity);
    for (const int row : {0, 30, 60, 90, 119}) {
      const double late_s = 0.2 * (row - 59.5) / 120;
      EXPECT_NEAR(edge(moved, row) - edge(still, row), pixels_per_s * late_s, 1.01) << row;
    }
  }
}

TEST_F(Shutter, TheExposureBlursAnEdgeOverTheMotionInItsTime) {
  Vector6d aside = Vector6d::Zero();
  aside(1) = 2;
  const double blur = kFocal * 2 / kWall_m * 0.25;  // pixels: 15
  const Picture sharp = picture(watcher(0.25, 0), Vector6d::Zero()), blurred = picture(watcher(0.25, 0), aside);
  const auto green = [](const Picture& p, int u) {
    return p.radiance[static_cast<std::size_t>(3 * (60 * p.width + u) + 1)];
  };
  const double far = green(sharp, 20), near = green(sharp, 140);
  ASSERT_GT(std::abs(far - near), 0.01);
  for (int u = 60; u < 100; ++u) {
    const double share = std::clamp((u - 79.5) / blur + 0.5, 0.0, 1.0);
    EXPECT_NEAR((green(blurred, u) - far) / (near - far), share, 0.08) << u;
  }
  EXPECT_EQ(blurred.depth_m, sharp.depth_m) << "geometry is that of the middle";
}

// A step that is blurred over b pixels differs from the step by b / 4 in sum: v t f / d. Pixels sample it.
TEST_F(Shutter, AnEdgeIsAsWideAsTheMotionAndCostsAPictureForEachPixelOfIt) {
  const Picture sharp = picture(watcher(0.1, 0), Vector6d::Zero());
  const auto green = [](const Picture& p, int u) {
    return double{p.radiance[static_cast<std::size_t>(3 * (60 * p.width + u) + 1)]};
  };
  for (const auto& [pixels, parts] : {std::pair(1.8, 3), std::pair(3.9, 5), std::pair(7.5, 9), std::pair(30.0, 15)}) {
    Vector6d aside = Vector6d::Zero();
    aside(1) = pixels * kWall_m / (kFocal * 0.1);
    RayRecord record;
    const Picture blurred = picture(watcher(0.1, 0), aside, 1, &record);
    std::ptrdiff_t rays = 0;
    for (const RayRecord::Packet& packet : record.packets) rays += std::ranges::count(packet.active, -1);
    double differs = 0;
    for (int u = 60; u < 100; ++u) differs += std::abs(green(blurred, u) - green(sharp, u));
    EXPECT_NEAR(4 * differs / std::abs(green(sharp, 82) - green(sharp, 77)), pixels, 1.25) << pixels;
    EXPECT_NEAR(static_cast<double>(rays) / (160 * 120), parts + 1 / 16.0, 1e-9) << pixels;
  }
}

TEST_F(Shutter, WithoutMotionOrWithoutTimeNothingChanges) {
  Vector6d aside = Vector6d::Zero();
  aside(1) = 2;
  const Picture plain = picture(watcher(0, 0), Vector6d::Zero());
  EXPECT_EQ(picture(watcher(0, 0), aside).rgb, plain.rgb);
  EXPECT_EQ(picture(watcher(0.1, 0.1), Vector6d::Zero()).rgb, plain.rgb);
  const Camera both = watcher(0.1, 0.1);
  EXPECT_EQ(picture(both, aside, 3).rgb, picture(both, aside, 1).rgb) << "threads";
}

}  // namespace
}  // namespace uwsim
