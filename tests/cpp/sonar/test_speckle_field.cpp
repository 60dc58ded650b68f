#include "uwsim/sonar/speckle_field.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace uwsim {
namespace {

constexpr int kPlaces = 20'000;

Pose looking_down(double x_m, double y_m) {
  return {{x_m, y_m, -2}, Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitY()))};
}

/// A level footprint 60 m below: the fan's y axis lies in its plane, z across it.
EchoFootprint footprint(float y_m, float z_m, float deviation_y_m, float deviation_z_m) {
  return {{60, y_m, z_m}, {0.01f, deviation_y_m, deviation_z_m}};
}

/// The correlation of draws for footprints whose distance is a given fraction of their deviation, over many positions.
double correlation(const SpeckleField& field, float apart_y, float apart_z, float deviation_y_m, float deviation_z_m,
                   std::size_t draw = 0) {
  double together = 0, one = 0, two = 0;
  for (int k = 0; k < kPlaces; ++k) {
    const SpeckleField::View view = field.view(looking_down(17.3 * k, 0.71 * k));
    const double a = view.draws(footprint(1, 0, deviation_y_m, deviation_z_m))[draw];
    const double b =
        view.draws(footprint(1 + apart_y * deviation_y_m, apart_z * deviation_z_m, deviation_y_m, deviation_z_m))[draw];
    together += a * b;
    one += a * a;
    two += b * b;
  }
  return together / std::sqrt(one * two);
}

TEST(SpeckleField, DrawsAreStandardNormalAndTheTwoAreIndependent) {
  const SpeckleField field(7, 400e3);
  double sum = 0, squares = 0, fourth = 0, other = 0, product = 0;
  for (int k = 0; k < kPlaces; ++k) {
    const auto [a, b] = field.view(looking_down(17.3 * k, 0.71 * k)).draws(footprint(1, 0, 0.37f, 0.2f));
    sum += a / kPlaces;
    squares += a * a / kPlaces;
    fourth += a * a * a * a / kPlaces;
    other += b * b / kPlaces;
    product += a * b / kPlaces;
  }
  EXPECT_NEAR(sum, 0, 0.03);
  EXPECT_NEAR(squares, 1, 0.04);
  EXPECT_NEAR(other, 1, 0.04);
  EXPECT_NEAR(product, 0, 0.03);
  EXPECT_NEAR(fourth / (squares * squares), 3, 0.2) << "kurtosis of a normal";
}

TEST(SpeckleField, BeamsCorrelateByTheOverlapOfTheirFootprints) {
  const SpeckleField field(7, 400e3);
  // 0.24 degrees apart with a beam of 1 degree: 0.57 standard deviations, exp(-0.57^2 / 4) = 0.92.
  const float close = 0.24f * 2.3548f;
  for (const float deviation_m : {0.05f, 0.26f, 0.4f, 3.1f}) {
    for (const float apart : {close, 1.0f, 1.5f, 2.0f}) {
      const double expected = std::exp(-apart * apart / 4), tolerance = apart == close ? 0.03 : 0.1;
      EXPECT_NEAR(correlation(field, apart, 0, deviation_m, 0.1f), expected, tolerance) << deviation_m << " " << apart;
      EXPECT_NEAR(correlation(field, 0, apart, 0.1f, deviation_m), expected, tolerance) << deviation_m << " " << apart;
    }
  }
  EXPECT_NEAR(correlation(field, close, 0, 0.26f, 0.1f, 1), 0.92, 0.03);
  EXPECT_NEAR(correlation(field, 6, 0, 0.26f, 0.1f), 0, 0.03) << "no overlap";
  EXPECT_NEAR(correlation(field, 0, 6, 0.26f, 0.1f), 0, 0.03);
}

TEST(SpeckleField, ScatterersAreFixedInTheWorld) {
  const SpeckleField field(7, 400e3);
  const auto here = field.view(looking_down(100, 40)).draws(footprint(2, 1, 0.3f, 0.2f));
  // The same footprint from another head with the same heading: 3 m along the fan's y axis, which is the world's, and 2
  // m along its z axis.
  const auto again = field.view(looking_down(98, 43)).draws(footprint(-1, -1, 0.3f, 0.2f));
  const auto other_way = field.view(looking_down(102, 43)).draws(footprint(-1, -1, 0.3f, 0.2f));
  const bool same = std::abs(here[0] - again[0]) < 1e-4, mirrored = std::abs(here[0] - other_way[0]) < 1e-4;
  EXPECT_NE(same, mirrored) << "the fan's z looks along the world's x, forward or back";
  const SpeckleField other(8, 400e3), higher(7, 700e3);
  EXPECT_NE(other.view(looking_down(100, 40)).draws(footprint(2, 1, 0.3f, 0.2f)), here);
  EXPECT_NE(higher.view(looking_down(100, 40)).draws(footprint(2, 1, 0.3f, 0.2f)), here);
}

TEST(SpeckleField, ASmallTurnKeepsTheLatticesAndBothSignsOfAQuaternionAreOne) {
  const SpeckleField field(7, 400e3);
  Pose pose = looking_down(100, 40);
  const auto before = field.view(pose).draws(footprint(0, 0, 0.3f, 0.2f));
  pose.orientation = pose.orientation * Eigen::AngleAxisd(1e-4, Eigen::Vector3d::UnitZ());
  const auto turned = field.view(pose).draws(footprint(0, 0, 0.3f, 0.2f));
  EXPECT_NEAR(turned[0], before[0], 0.1);
  pose.orientation.coeffs() *= -1;
  EXPECT_EQ(field.view(pose).draws(footprint(0, 0, 0.3f, 0.2f)), turned);
}

TEST(EchoFootprint, HasTheMomentsOfTheHits) {
  Eigen::Matrix3Xf directions(3, 2);
  directions << 0.6f, 0.6f, 0.8f, -0.8f, 0, 0;
  const std::vector<RayEcho> rays{{10, 1, 1, 1, kTerrain, 1}, {10, 1, 1, 1, kTerrain, 0}};
  const EchoFootprint found = echo_footprint(rays, directions);
  EXPECT_LT((found.middle_m - Eigen::Vector3f(6, 0, 0)).norm(), 1e-5);
  EXPECT_LT((found.deviation_m - Eigen::Vector3f(0, 8, 0)).norm(), 1e-5);
}

}  // namespace
}  // namespace uwsim
