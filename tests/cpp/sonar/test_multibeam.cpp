#include "uwsim/sonar/sonar_head.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "meshes.h"
#include "sonar/imaging_pool.h"
#include "uwsim/core/check.h"

namespace uwsim {
namespace {

SonarHead head(int model, double elevation_rad, const Pose& body_from_mount = {}) {
  return {{"sonar", em2040(model), body_from_mount, elevation_rad, std::nullopt}, Water{}, RandomStream(0, "sonar")};
}

TEST(MultibeamModel, TheFourVariantsAreAsPublished) {
  for (const auto& [number, beams, degrees, range, khz] :
       {std::tuple{1, 513, 85, 95, 600}, {2, 513, 85, 55, 700}, {3, 1025, 170, 95, 600}, {4, 1025, 170, 55, 700}}) {
    const MultibeamModel& model = em2040(number);
    EXPECT_EQ(model.beams, beams);
    EXPECT_NEAR(model.field_of_view_rad, degrees * std::numbers::pi / 180, 1e-12);
    EXPECT_EQ(model.range_max_m, range);
    EXPECT_EQ(model.frequency_hz, khz * 1e3);
    EXPECT_NEAR(model.angles().at(0), -model.field_of_view_rad / 2, 1e-12);
    EXPECT_NEAR(model.angles().at(beams - 1), model.field_of_view_rad / 2, 1e-12);
    EXPECT_NEAR(model.angles().at(beams / 2), 0, 1e-12) << "an odd number of beams: one looks straight ahead";
  }
  EXPECT_THROW(em2040(5), InvalidValue);
}

TEST(Multibeam, TheRangeToAFlatBedIsTheHeightOverTheSineOfTheDip) {
  const RayScene scene(testing::flat_bed(-20));
  const double tilt = 0.6;
  const SonarHead sonar = head(4, -tilt, Pose{{0.5, 0, -0.2}, Eigen::Quaterniond::Identity()});
  const Pose body{{3, 2, -8}, Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()))};
  const MultibeamPing ping = sonar.ping(scene, Water{}, body);
  for (int beam = 0; beam < 1025; ++beam) {
    const auto k = static_cast<std::size_t>(beam);
    const double expected = (20 - 8 - 0.2) / (std::sin(tilt) * std::cos(em2040(4).angles().at(beam)));
    if (expected < 54.99) {
      ASSERT_EQ(ping.valid[k], 1);
      EXPECT_NEAR(ping.ranges_m[k], expected, 1e-5);
      EXPECT_NEAR(std::cos(ping.incidence_rad[k]), (20 - 8.2) / expected, 1e-5);
      EXPECT_EQ(ping.labels[k], kTerrain);
    } else if (expected > 55) {
      EXPECT_EQ(ping.valid[k], 0);
      EXPECT_TRUE(std::isinf(ping.ranges_m[k]) && std::isinf(ping.intensity_db[k]));
      EXPECT_EQ(ping.labels[k], kNothing);
    }
  }
}

TEST(Multibeam, PositiveElevationIsUpAndPositiveAnglesAreToPort) {
  World world;
  TriangleMesh target = testing::box(1, 1, 1);
  const double up = 0.5;
  for (auto& v : target.vertices_m) v += Eigen::Vector3d(20 * std::cos(up), 0, -30 + 20 * std::sin(up));
  world.add_solid("above", target);
  for (auto& v : target.vertices_m) v += Eigen::Vector3d(0, 10, 0);
  world.add_solid("above to port", target);
  const SonarHead sonar = head(2, up);
  const MultibeamPing ping = sonar.ping(RayScene(world), Water{}, {{0, 0, -30}, Eigen::Quaterniond::Identity()});
  EXPECT_EQ(ping.labels[256], kTerrain + 1);
  bool port = false;
  for (std::size_t k = 0; k < 513; ++k) port |= ping.labels[k] == kTerrain + 2 && k > 256;
  EXPECT_TRUE(port);
}

TEST(Multibeam, EchoesWeakenWithRangeAndIncidenceAsTheSonarEquationSays) {
  const auto level = [](float depth) {
    const SonarHead sonar = head(1, -std::numbers::pi / 2);
    const RayScene scene(testing::flat_bed(-depth));
    return sonar.ping(scene, Water{}, Pose{{0, 0, -1}, Eigen::Quaterniond::Identity()}).intensity_db;
  };
  const auto near = level(11), far = level(41);  // 10 m and 40 m straight below
  const double spreading = 40 * std::log10(4.0);
  EXPECT_GT(near[256] - far[256], spreading);
  EXPECT_LT(near[256] - far[256], spreading + 60 * 0.5) << "absorption of under 0.5 dB/m";
  EXPECT_LT(near[0], near[256]);
}

TEST(Multibeam, AnEchoIsAsStrongAsWhatItWasReturnedBy) {
  const RayScene scene(testing::flat_bed(-20));
  const Pose pose{{0, 0, -5}, Eigen::Quaterniond(Eigen::AngleAxisd(1.2, Eigen::Vector3d::UnitY()))};
  const std::vector<double> mud{-30, -44};  // nothing, terrain
  const MultibeamPing rock = Multibeam(em2040(1)).ping(scene, Water{}, pose);
  const MultibeamPing soft = Multibeam(em2040(1), mud).ping(scene, Water{}, pose);
  EXPECT_EQ(rock.ranges_m, soft.ranges_m);
  for (std::size_t k = 0; k < 513; ++k) {
    ASSERT_EQ(rock.valid[k], 1);
    EXPECT_NEAR(rock.intensity_db[k] - soft.intensity_db[k], 14, 1e-4);
  }
  EXPECT_THROW(Multibeam(em2040(1), std::vector<double>{0, 31}), InvalidValue);
}

TEST(Multibeam, SoundDoesNotLeaveTheWater) {
  World world = testing::flat_bed(-20);
  TriangleMesh bank = testing::box(1, 60, 10);  // from z = -5 up to z = 5
  for (auto& v : bank.vertices_m) v += Eigen::Vector3d(10, 0, 0);
  world.add_solid("bank", bank);
  const RayScene scene(world);
  const SonarHead sonar = head(2, 0.05);
  const auto echoes = [&](double z) {
    return sonar.ping(scene, Water{}, {{0, 0, z}, Eigen::Quaterniond::Identity()}).valid;
  };
  EXPECT_EQ(echoes(-2)[256], 1);
  EXPECT_EQ(echoes(-0.2)[256], 0) << "hits the bank above the surface";
  EXPECT_EQ(echoes(1)[256], 0) << "a head above the water";
}

TEST(Multibeam, AHeadUnderTheGroundReceivesNoEchoAndAHeadInASolidThoseOfItsWalls) {
  World world = testing::flat_bed(-20);
  TriangleMesh hollow = testing::box(4, 4, 4);
  for (auto& v : hollow.vertices_m) v += Eigen::Vector3d(50, 0, -10);
  world.add_solid("hollow", hollow);
  world.add_solid("buried", testing::box(1, 1, 1), {sphere({3, 0, -25}, 1)});
  const RayScene scene(world);
  const Multibeam sonar(em2040(2));
  const auto ping = [&](const Eigen::Vector3d& at) {
    return sonar.ping(scene, Water{}, {at, Eigen::Quaterniond::Identity()});
  };
  for (const Eigen::Vector3d& under : {Eigen::Vector3d(0, 0, -25), Eigen::Vector3d(0, 0, -20)}) {
    const MultibeamPing empty = ping(under);
    for (std::size_t k = 0; k < 513; ++k) {
      EXPECT_EQ(empty.valid[k], 0);
      EXPECT_EQ(empty.labels[k], kNothing);
      EXPECT_TRUE(std::isinf(empty.ranges_m[k]));
    }
  }
  const MultibeamPing walled = ping({50, 0, -10});
  EXPECT_EQ(walled.labels[256], kTerrain + 1);
  EXPECT_NEAR(walled.ranges_m[256], 2, 1e-6);
}

TEST(Multibeam, ThePingRateIsLimitedByTheTwoWayTravelTime) {
  Water water;
  water.surface_temperature_deg_c = water.bottom_temperature_deg_c = 10;
  water.salinity_psu = 35;
  for (const auto& [number, range] : {std::pair{1, 95.0}, {2, 55.0}}) {
    // Mackenzie's own value at 10 deg C, 35 psu and the surface is 1489.8 m/s.
    EXPECT_NEAR(Multibeam(em2040(number)).ping_rate_max_hz(water, 0), 1489.8 / (2 * range), 0.01);
  }
  MultibeamModel near = em2040(1);
  near.range_max_m = 1;
  EXPECT_EQ(Multibeam(near).ping_rate_max_hz(water, 0), near.ping_rate_max_hz) << "the electronics' limit";
}

}  // namespace
}  // namespace uwsim
