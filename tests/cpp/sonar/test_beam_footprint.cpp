#include "uwsim/sonar/beam_footprint.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

TEST(BeamFootprint, HasTheMomentsOfTheGaussianPatternForAnyNumberOfRays) {
  for (const int rays : {4, 8, 16, 64}) {
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    Eigen::Matrix2d second = Eigen::Matrix2d::Zero();
    for (const auto& offset : BeamFootprint::offsets(rays)) {
      mean += offset / rays;
      second += offset * offset.transpose() / rays;
    }
    EXPECT_LT(mean.norm(), 1e-12);
    EXPECT_LT((second - Eigen::Matrix2d::Identity()).norm(), 1e-12);
  }
  EXPECT_THROW(BeamFootprint::offsets(0), InvalidValue);
  EXPECT_THROW(BeamFootprint::offsets(3), InvalidValue);
  EXPECT_THROW(BeamFootprint::offsets(65), InvalidValue);
}

TEST(BeamFootprint, WidensWithTheSteeringOfItsReceiver) {
  MultibeamModel fan = em2040(1);
  fan.beams = 3;
  fan.field_of_view_rad = 2 * std::numbers::pi / 3;
  const auto width_rad = [&](Eigen::Index beam) {
    const BeamFootprint footprint(fan, 0.01, 0.01, 16);
    const Eigen::Vector3f axis = footprint.axes().col(beam), aside(-axis.y(), axis.x(), 0);
    const auto rays = footprint.directions().middleCols(16 * beam, 16);
    return std::sqrt((aside.transpose() * rays).squaredNorm() / 16);
  };
  EXPECT_NEAR(width_rad(0) / width_rad(1), 2, 1e-3) << "at 60 degrees";
  fan.receiver_tilt_rad = std::numbers::pi / 3;
  EXPECT_NEAR(width_rad(1) / width_rad(0), 2, 1e-3) << "two receivers that face 60 degrees to their sides";
  EXPECT_NEAR(width_rad(0), 0.01 / 2.3548, 1e-6);
}

}  // namespace
}  // namespace uwsim
