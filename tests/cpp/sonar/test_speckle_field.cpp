#include "uwsim/sonar/speckle_field.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <utility>

namespace uwsim {
namespace {

constexpr int kPlaces = 20'000;

/// At 400 kHz; half the receiver is 0.138 m long, half the transmitter 0.237 m.
const SonarParameters kSonar{.frequency_hz = 400e3, .beam_width_along_rad = 0.007, .beam_width_across_rad = 0.012};

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
  const SpeckleField field(7, kSonar);
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
  const SpeckleField field(7, kSonar);
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
  const SpeckleField field(7, kSonar);
  const double turn_rad = 0.01;
  double same = 0, elsewhere = 0;
  for (int k = 0; k < kPlaces; ++k) {
    Pose pose = looking_down(17.3 * k, 0.71 * k);
    const double here = field.view(pose).draws(footprint(1, 0, 0.3f, 0.2f))[0];
    pose.orientation = pose.orientation * Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitZ());
    const auto moved_m = static_cast<float>(60 * turn_rad);  // two standard deviations
    same += here * field.view(pose).draws(footprint(1 - moved_m, 0, 0.3f, 0.2f))[0] / kPlaces;
    elsewhere += here * field.view(pose).draws(footprint(1, 0, 0.3f, 0.2f))[0] / kPlaces;
  }
  EXPECT_GT(same, 0.97) << "a turned head finds them in other beams";
  EXPECT_LT(elsewhere, 0.5);
  const Pose pose = looking_down(100, 40);
  const auto here = field.view(pose).draws(footprint(2, 1, 0.3f, 0.2f));
  const SpeckleField other(8, kSonar);
  SonarParameters higher = kSonar;
  higher.frequency_hz = 700e3;
  EXPECT_NE(other.view(pose).draws(footprint(2, 1, 0.3f, 0.2f)), here);
  EXPECT_NE(SpeckleField(7, higher).view(pose).draws(footprint(2, 1, 0.3f, 0.2f)), here);
}

TEST(SpeckleField, DecorrelatesAsTheArrayMovesByHalfItsLength) {
  const SpeckleField field(7, kSonar);
  // Looking down, the fan's y axis is the world's, along which the receiver lies; its z axis is the world's x.
  const auto after = [&](double x_m, double y_m) {
    double sum = 0;
    for (int k = 0; k < kPlaces; ++k) {
      const double x = 17.3 * k, y = 0.71 * k;
      const auto y_apart = static_cast<float>(-y_m), z_apart = static_cast<float>(-x_m);  // the same footprint
      sum += field.view(looking_down(x, y)).draws(footprint(1, 0, 3, 3))[0] *
             field.view(looking_down(x + x_m, y + y_m)).draws(footprint(1 + y_apart, z_apart, 3, 3))[0];
    }
    return sum / kPlaces;
  };
  for (const auto& [x_m, y_m] : {std::pair{0.237, 0.0}, std::pair{0.0, 0.138}}) {
    EXPECT_GT(after(0.05 * x_m, 0.05 * y_m), 0.95);
    EXPECT_NEAR(after(0.5 * x_m, 0.5 * y_m), 0.25, 0.1) << "an unshaded line array";
    EXPECT_NEAR(after(x_m, y_m), 0, 0.03);
    EXPECT_NEAR(after(2 * x_m, 2 * y_m), 0, 0.03);
  }
}

TEST(SpeckleField, ASmallTurnKeepsTheLatticesAndBothSignsOfAQuaternionAreOne) {
  const SpeckleField field(7, kSonar);
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
