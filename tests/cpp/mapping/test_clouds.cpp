#include "uwsim/mapping/clouds.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

using Eigen::Matrix4d;
using Eigen::Vector3d;
using Rows = Eigen::Map<const Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>>;

constexpr float kInf = std::numeric_limits<float>::infinity();
const float kNan = std::nanf("");

Rows rows(const std::vector<float>& points_m) {
  return {points_m.data(), static_cast<Eigen::Index>(points_m.size() / 3), 3};
}

std::vector<float> scattered_points(int n) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> uniform(-50.0f, 50.0f);
  std::vector<float> points_m(static_cast<std::size_t>(3 * n));
  for (float& x : points_m) x = uniform(random);
  return points_m;
}

Matrix4d some_pose() {
  Matrix4d pose = Matrix4d::Identity();
  pose.topLeftCorner<3, 3>() = Eigen::AngleAxisd(0.7, Vector3d(1, -2, 3).normalized()).toRotationMatrix();
  pose.topRightCorner<3, 1>() = Vector3d(12, -34, -8);
  return pose;
}

TEST(Clouds, PointsLieAlongTheAnglesOfTheirBeams) {
  const double fov = 85 * std::numbers::pi / 180;
  const ScanGeometry geometry{-fov / 2, fov / 512, 0, 54.9};
  const std::vector<float> points_m = scan_to_points(std::vector<float>(513, 20.0f), geometry);
  ASSERT_EQ(rows(points_m).rows(), 513);
  for (int i = 0; i < 513; ++i) {
    const Vector3d p = rows(points_m).row(i).cast<double>();
    EXPECT_NEAR(std::atan2(p.y(), p.x()), -fov / 2 + i * fov / 512, 1e-7);  // from starboard to port
    EXPECT_NEAR(p.norm(), 20, 1e-5);
    EXPECT_EQ(p.z(), 0);
  }
}

TEST(Clouds, RangesOutsideTheScansLimitsAreDiscarded) {
  const std::vector<float> ranges_m = {kInf, kNan, 0.5f, 1.0f, 2.0f, 10.0f, -kInf, -3.0f};
  const std::vector<float> points_m = scan_to_points(ranges_m, {0, 0, 1.0, 10.0});
  EXPECT_EQ(points_m, (std::vector<float>{1, 0, 0, 2, 0, 0}));
}

TEST(Clouds, TransformAndItsInverseGiveThePointsBack) {
  const std::vector<float> points_m = scattered_points(200);
  const Matrix4d pose = some_pose();
  const std::vector<float> back_m = transform_points(transform_points(points_m, pose), pose.inverse());
  EXPECT_LT((rows(back_m) - rows(points_m)).cwiseAbs().maxCoeff(), 2e-5);
}

TEST(Clouds, TransformKeepsLengthsAndCarriesTheOrigin) {
  const std::vector<float> points_m = {0, 0, 0, 3, 4, 0, -1, 5, 7};
  const std::vector<float> moved_m = transform_points(points_m, some_pose());
  EXPECT_LT((rows(moved_m).row(0) - Eigen::RowVector3f(12, -34, -8)).norm(), 1e-6);
  for (const int i : {1, 2}) {
    EXPECT_NEAR((rows(moved_m).row(i) - rows(moved_m).row(0)).norm(), rows(points_m).row(i).norm(), 1e-5);
  }
}

TEST(Clouds, TransformsThatAreNotRigidAreRefused) {
  Matrix4d scaled = 2 * Matrix4d::Identity();
  scaled(3, 3) = 1;
  Matrix4d mirrored = Matrix4d::Identity();
  mirrored(2, 2) = -1;
  Matrix4d broken = Matrix4d::Identity();
  broken(0, 3) = kNan;
  for (const Matrix4d& bad : {scaled, mirrored, broken, Matrix4d(Matrix4d::Zero())}) {
    EXPECT_THROW(transform_points(std::vector<float>{1, 2, 3}, bad), InvalidValue);
  }
}

TEST(Clouds, RangeFilterKeepsPointsAtItsLimits) {
  const std::vector<float> points_m = {1, 0, 0, 0, 2, 0, 0, 0, 5, 3, 4, 0, 0, 0, 5.01f, kNan, 0, 0, kInf, 0, 0};
  EXPECT_EQ(filter_range(points_m, 2, 5), (std::vector<float>{0, 2, 0, 0, 0, 5, 3, 4, 0}));
}

TEST(Clouds, PointsAreEitherInTheBoxOrKept) {
  const std::vector<float> points_m = scattered_points(500);
  const Vector3d low(-20, -30, -40), high(10, 25, 5);
  const std::vector<float> outside_m = remove_box(points_m, low, high);
  Eigen::Index inside = 0;
  for (Eigen::Index i = 0; i < rows(points_m).rows(); ++i) {
    const Vector3d p = rows(points_m).row(i).cast<double>();
    inside += ((p - low).array() >= 0).all() && ((high - p).array() >= 0).all();
  }
  EXPECT_GT(inside, 0);
  EXPECT_EQ(rows(outside_m).rows() + inside, rows(points_m).rows());
  EXPECT_EQ(remove_box(outside_m, low, high), outside_m);
  EXPECT_TRUE(remove_box(std::vector<float>{1, 1, 1, kNan, 0, 0}, Vector3d::Zero(), Vector3d::Ones()).empty());
  EXPECT_THROW(remove_box(points_m, high, low), InvalidValue);
}

TEST(Clouds, AScanInTheWorldIsTheSameInOneCallAndStepByStep) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> uniform(-1.0f, 12.0f);
  const ScanGeometry geometry{-0.75, 0.003, 0.5, 10.0};
  const Vector3d low(-2, -3, -4), high(4, 2, 1);
  Matrix4d body_from_sonar = Matrix4d::Identity();
  body_from_sonar.topLeftCorner<3, 3>() = Eigen::AngleAxisd(0.4, Vector3d::UnitY()).toRotationMatrix();
  body_from_sonar.topRightCorner<3, 1>() = Vector3d(0.3, 0, -0.2);
  const Matrix4d world_from_body = some_pose(), world_from_sonar = world_from_body * body_from_sonar;
  std::vector<float> ranges_m(501);
  for (float& range_m : ranges_m) range_m = uniform(random);
  ranges_m[7] = kInf, ranges_m[8] = kNan;

  const std::vector<float> near_m = filter_range(scan_to_points(ranges_m, geometry), 0.5, 10.0);
  const std::vector<float> body_m = transform_points(near_m, relative_transform(world_from_body, world_from_sonar));
  const std::vector<float> others_m = remove_box(body_m, low, high);
  ASSERT_GT(others_m.size(), 0);
  ASSERT_LT(others_m.size(), body_m.size());
  EXPECT_EQ(scan_to_world(ranges_m, geometry, low, high, world_from_body, world_from_sonar),
            transform_points(others_m, world_from_body));
  EXPECT_TRUE(scan_to_world({}, geometry, low, high, world_from_body, world_from_sonar).empty());
  EXPECT_THROW(scan_to_world(ranges_m, geometry, high, low, world_from_body, world_from_sonar), InvalidValue);
  EXPECT_THROW(scan_to_world(ranges_m, geometry, low, high, 2 * world_from_body, world_from_sonar), InvalidValue);
}

TEST(Clouds, EmptyCloudsStayEmpty) {
  EXPECT_TRUE(transform_points({}, some_pose()).empty());
  EXPECT_TRUE(filter_range({}, 0, 1).empty());
  EXPECT_TRUE(remove_box({}, Vector3d::Zero(), Vector3d::Ones()).empty());
}

}  // namespace
}  // namespace uwsim
