#include "uwsim/sonar/sonar_head.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

const RandomStream kStream(3, "rov/sonar");

SonarHead head(double elevation_rad, std::optional<AcousticSpec> acoustics = std::nullopt) {
  const Pose mount{{0.5, 0, -0.2}, Eigen::Quaterniond::Identity()};
  return {{"sonar", em2040(2), mount, elevation_rad, std::move(acoustics)}, Water{}, kStream};
}

RayScene flat_bed() {
  World world;
  world.set_terrain(Heightfield(std::vector<float>(4, -20), 2, 2, 400.0, {-200, -200}));
  return RayScene(world);
}

TEST(SonarHead, TurnsAtItsTiltRateAsTimePasses) {
  SonarHead sonar = head(-0.5);
  EXPECT_EQ(sonar.elevation_rad(), -0.5);
  sonar.aim(std::numbers::pi / 2);
  EXPECT_EQ(sonar.elevation_rad(), -0.5) << "no time has passed";
  sonar.advance(1);
  EXPECT_NEAR(sonar.elevation_rad(), -0.5 + 5 * std::numbers::pi / 180, 1e-6) << "5 degrees per second";
  for (int k = 0; k < 30; ++k) sonar.advance(1);
  EXPECT_EQ(sonar.elevation_rad(), std::numbers::pi / 2);
  sonar.aim(1.5);
  sonar.advance(10);
  EXPECT_EQ(sonar.elevation_rad(), 1.5) << "without overshoot";
  EXPECT_THROW(sonar.aim(NAN), InvalidValue);
  EXPECT_THROW(sonar.aim(1.6), InvalidValue);
  EXPECT_THROW(head(-1.6), InvalidValue);
}

TEST(SonarHead, PingsInPhysicsModeFromItsPoseWithTheMotionOfItsMount) {
  const RayScene scene = flat_bed();
  const SonarHead sonar = head(-0.9, AcousticSpec{});
  BodyState body;
  body.world_from_body = {{3, 2, -8}, Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()))};
  body.velocity_body << 1, 0.2, 0, 0, 0.1, 0.3;
  const AcousticMultibeam instrument(em2040(2), AcousticSpec{}, Water{}, Water{}.bottom_depth_m, kStream);
  const Eigen::Vector3d rate(0, 0.1, 0.3);
  const Eigen::Vector3d velocity = Eigen::Vector3d(1, 0.2, 0) + rate.cross(Eigen::Vector3d(0.5, 0, -0.2));
  const Eigen::Quaterniond& turn = body.world_from_body.orientation;
  const AcousticPing expected =
      instrument.ping(scene, body.world_from_body * sonar.body_from_sonar(), {turn * velocity, turn * rate}, 7);
  const AcousticPing ping = sonar.acoustic_ping(scene, body, 7);
  EXPECT_EQ(ping.ranges_m, expected.ranges_m);
  EXPECT_EQ(ping.intensity_db, expected.intensity_db);
}

TEST(SonarHead, HasPhysicsModeOnlyWithAcoustics) {
  EXPECT_TRUE(head(0, AcousticSpec{}).in_physics_mode());
  EXPECT_FALSE(head(0).in_physics_mode());
  EXPECT_THROW(head(0).acoustic_ping(flat_bed(), BodyState{}, 0), InvalidValue);
}

}  // namespace
}  // namespace uwsim
