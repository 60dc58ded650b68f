#include "uwsim/sonar/depth_image.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sonar/imaging_pool.h"
#include "uwsim/core/check.h"

namespace uwsim {
namespace {

using testing::at;
using testing::flat_bed;
using testing::kDegree;

DepthCamera camera(int width, int height) { return {width, height, 85 * kDegree, 20 * kDegree, 55, 0}; }

std::vector<double> beams(int count) {
  std::vector<double> angles;
  for (int k = 0; k < count; ++k) angles.push_back((-42.5 + 85.0 * k / (count - 1)) * kDegree);
  return angles;
}

TEST(DepthImage, ATiltedCameraRendersAFlatBedAtTheDepthOfItsPlane) {
  const DepthCamera view = camera(64, 32);
  const double tilt = 40 * kDegree;
  const DepthImage image = depth_image(view, RayScene(flat_bed(-20)), at({0, 0, -12}, tilt));
  for (int row = 0; row < 32; ++row) {
    const double up = std::tan(10 * kDegree) * (1 - (2 * row + 1) / 32.0);
    const double expected =
        8 / (std::sin(tilt) - up * std::cos(tilt));  // the ray at depth 1 descends by the denominator
    for (int column = 0; column < 64; ++column) {
      EXPECT_NEAR(image.depth_m[static_cast<std::size_t>(64 * row + column)], expected, 1e-4);
    }
  }
}

TEST(DepthImage, ColumnsAreConvertedToRangesWithinHalfAPixel) {
  const double tilt = 30 * kDegree, h = 6;
  for (const int width : {128, 512, 2048}) {
    const DepthImage image = depth_image(camera(width, 1), RayScene(flat_bed(-20)), at({0, 0, -20 + h}, tilt));
    const std::vector<double> angles = beams(513);
    const auto nearest = depth_image_ranges(image, angles, RowReduction::kMiddle, false);
    const auto between = depth_image_ranges(image, angles, RowReduction::kMiddle, true);
    for (std::size_t k = 0; k < angles.size(); ++k) {
      const double exact = h / std::sin(tilt) / std::cos(angles[k]);
      EXPECT_NEAR(nearest[k], exact, 1e-4) << "the bed's depth is the same in all columns of one row";
      EXPECT_NEAR(between[k], exact, 1e-4);
    }
  }
}

TEST(DepthImage, OnAnObliqueWallTheErrorIsThatOfHalfAPixelAndInterpolationRemovesIt) {
  World world;  // a wall across the view at 45 degrees
  TriangleMesh wall = testing::box(400, 1, 40);
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(-45 * kDegree, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  for (auto& v : wall.vertices_m) v = turn * (v + Eigen::Vector3d(0, 10.5, 0)) + Eigen::Vector3d(0, 0, -30);
  world.add_solid("wall", wall);
  double last = 1e9;
  for (const int width : {128, 256, 512, 1024}) {
    const DepthImage image = depth_image(camera(width, 1), RayScene(world), at({0, 0, -30}));
    const std::vector<double> angles = beams(513);
    const auto nearest = depth_image_ranges(image, angles, RowReduction::kMiddle, false);
    const auto between = depth_image_ranges(image, angles, RowReduction::kMiddle, true);
    double worst = 0;
    for (std::size_t k = 1; k + 1 < angles.size(); ++k) {
      const double exact = 10 / std::sin(45 * kDegree + angles[k]);
      if (exact > 40 || angles[k] < -42 * kDegree || angles[k] > 42 * kDegree) continue;
      worst = std::max(worst, std::abs(nearest[k] - exact));
      EXPECT_NEAR(between[k], exact, 1e-4) << width << " " << angles[k] / kDegree;
    }
    EXPECT_LT(worst, 0.6 * last) << "half the pixel, half the error";
    last = worst;
  }
  EXPECT_GT(last, 1e-3);
}

TEST(DepthImage, TheNearestRowDetectsATargetAboveTheFan) {
  World world = flat_bed(-40);
  TriangleMesh target = testing::box(0.5, 4, 0.5);
  for (auto& v : target.vertices_m) v += Eigen::Vector3d(12.25, 0, -20 + 1.2);
  world.add_solid("above", target);
  const DepthImage image = depth_image(camera(65, 64), RayScene(world), at({0, 0, -20}));
  const std::array ahead{0.0};
  EXPECT_TRUE(std::isinf(depth_image_ranges(image, ahead, RowReduction::kMiddle, false)[0]));
  EXPECT_NEAR(depth_image_ranges(image, ahead, RowReduction::kNearest, false)[0], std::hypot(12, 0.95), 0.03);
}

TEST(DepthImage, AQuantisedDepthIsAMultipleOfTheStep) {
  DepthCamera coarse = camera(33, 1);
  coarse.depth_bits = 8;
  const DepthImage image = depth_image(coarse, RayScene(flat_bed(-20)), at({0, 0, -15}, 30 * kDegree));
  const double step = 55.0 / 255;
  EXPECT_NEAR(image.depth_m[16], std::round(10 / step) * step, 1e-5);
  EXPECT_GT(std::abs(image.depth_m[16] - 10), 1e-3);
}

TEST(DepthImage, DepthIsInfiniteBeyondTheFarPlaneAboveTheWaterAndOutsideTheView) {
  const RayScene scene(flat_bed(-20));
  const DepthImage level = depth_image(camera(32, 1), scene, at({0, 0, -15}));
  for (const float depth : level.depth_m) EXPECT_TRUE(std::isinf(depth)) << "the bed rises to the horizon";
  for (const float depth : depth_image(camera(32, 1), scene, at({0, 0, 2}, 60 * kDegree)).depth_m) {
    EXPECT_TRUE(std::isinf(depth)) << "a camera above the water";
  }
  World world;
  TriangleMesh ship = testing::box(2, 40, 4);
  for (auto& v : ship.vertices_m) v += Eigen::Vector3d(10, 0, 3);
  world.add_solid("dry", ship);
  for (const float depth : depth_image(camera(32, 8), RayScene(world), at({0, 0, -0.5}, -15 * kDegree)).depth_m) {
    EXPECT_TRUE(std::isinf(depth)) << "surfaces above the water";
  }
  const DepthImage down = depth_image(camera(32, 1), scene, at({0, 0, -15}, 60 * kDegree));
  const std::array angles{50 * kDegree, 100 * kDegree, std::numbers::pi};
  for (const float range : depth_image_ranges(down, angles, RowReduction::kMiddle, true)) {
    EXPECT_TRUE(std::isinf(range));
  }
}

TEST(DepthImage, RefusesParametersOutOfRange) {
  const auto refused = [](auto change) {
    DepthCamera view = camera(64, 4);
    change(view);
    EXPECT_THROW(view.check(), InvalidValue);
  };
  EXPECT_NO_THROW(camera(64, 4).check());
  refused([](auto& c) { c.width = 0; });
  refused([](auto& c) { c.height = 70000; });
  refused([](auto& c) { c.width = c.height = 60000; });
  refused([](auto& c) { c.horizontal_fov_rad = std::numbers::pi; });
  refused([](auto& c) { c.vertical_fov_rad = -1; });
  refused([](auto& c) { c.range_max_m = std::nan(""); });
  refused([](auto& c) { c.depth_bits = 33; });
}

}  // namespace
}  // namespace uwsim
