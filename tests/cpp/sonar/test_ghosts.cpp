#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "meshes.h"
#include "uwsim/acoustics/absorption.h"
#include "uwsim/sonar/acoustic_multibeam.h"

// Echoes that arrive by more than one bounce, targets in the water, and the water column, compared with image sources
// and with the sonar equation.
namespace uwsim {
namespace {

constexpr double kQuarterTurn = std::numbers::pi / 2;

World level_bed(float z_m) {
  World world;
  world.set_terrain(Heightfield({z_m, z_m, z_m, z_m}, 2, 2, 2000, {-1000, -1000}));
  return world;
}

Water uniform_water() {
  Water water;
  water.surface_temperature_deg_c = water.bottom_temperature_deg_c = 8;
  return water;
}

AcousticSpec quiet_spec() {
  AcousticSpec spec;
  spec.parameters.source_level_db = 300;
  spec.parameters.beam_width_across_rad = 0.02;
  spec.false_detections = false;
  spec.range_noise = false;
  spec.bottom = {-30, 0};
  return spec;
}

AcousticMultibeam narrow_sonar(const AcousticSpec& spec, double range_max_m = 70, double field_of_view_rad = 0.02) {
  MultibeamModel fan = em2040(1);
  fan.beams = 3;
  fan.field_of_view_rad = field_of_view_rad;
  fan.range_max_m = range_max_m;
  return AcousticMultibeam(fan, spec, uniform_water(), 1000, RandomStream(5, "rov/sonar"));
}

/// A head whose axis points down by an angle.
Pose dipping(double depth_m, double dip_rad) {
  return {{0, 0, -depth_m}, Eigen::Quaterniond(Eigen::AngleAxisd(dip_rad, Eigen::Vector3d::UnitY()))};
}

struct Sonar {
  AcousticMultibeam instrument;
  RayScene scene;
  Pose pose;

  AcousticPing ping(std::uint64_t tick = 0, int threads = 1) const {
    return instrument.ping(scene, pose, {}, tick, threads, {0, true});
  }

  double cell_m() const { return instrument.spec().parameters.range_cell_m(sound_speed_m_s(8, 0, 0)); }

  /// The energy of the middle beam between two ranges, as if it fell into one range cell, relative to the source: the
  /// mean over pings, which averages out speckle.
  double energy(double from_m, double to_m, int pings = 500) const {
    double sum = 0;
    for (int tick = 0; tick < pings; ++tick) {
      const AcousticPing ping = this->ping(static_cast<std::uint64_t>(tick));
      const std::size_t samples = ping.water_column_db.size() / 3;
      for (std::size_t k = 0; k < samples; ++k) {
        const double range_m = (static_cast<double>(k) + 0.5) * ping.water_column_sample_m;
        if (range_m < from_m || range_m > to_m) continue;
        sum += std::pow(10, 0.1 * ping.water_column_db[samples + k]) * ping.water_column_sample_m / cell_m();
      }
    }
    return sum / pings;
  }

  double lost(double range_m) const {
    const double absorption = absorption_db_km(instrument.spec().parameters.frequency_hz, 8, 0, 10) / 1000;
    return std::pow(10, -0.2 * absorption * range_m);
  }
  double solid_angle_sr() const { return instrument.spec().parameters.beam_solid_angle_sr(); }
};

TEST(Ghosts, TheSecondEchoOfALevelBedIsAtTwiceTheRangeWithTheLevelOfItsImage) {
  AcousticSpec spec = quiet_spec();
  spec.multipath = true;
  const double h = 20, reflected = std::pow(10, -0.1 * bottom_loss_db(spec.bottom.fluid, kQuarterTurn));
  const Sonar sonar{narrow_sonar(spec), RayScene(level_bed(-20)), dipping(1e-3, kQuarterTurn)};
  const double scattered = sonar.solid_angle_sr() * 1e-3;
  const double first = scattered / (h * h) * sonar.lost(h);
  EXPECT_NEAR(10 * std::log10(sonar.energy(h - 0.5, h + 0.5) / first), 0, 0.3);
  // Down; or down, up and down again: the source's image is at 3 h. Either way out, the other one back.
  const double second = scattered * 2 * reflected / (3 * h * h) * sonar.lost(2 * h);
  EXPECT_NEAR(10 * std::log10(sonar.energy(2 * h - 0.5, 2 * h + 0.5) / second), 0, 0.3);
  const double third = scattered * reflected * reflected / (9 * h * h) * sonar.lost(3 * h);
  EXPECT_NEAR(10 * std::log10(sonar.energy(3 * h - 0.5, 3 * h + 0.5) / third), 0, 0.4);
}

TEST(Ghosts, ABeamThatLooksUpReceivesTheBedsImageInTheSurface) {
  AcousticSpec spec = quiet_spec();
  const double depth = 5, height = 15, up = 30 * std::numbers::pi / 180, path = (2 * depth + height) / std::sin(up);
  const RayScene scene(level_bed(-20));
  const Pose pose = dipping(depth, -up);
  EXPECT_EQ(narrow_sonar(spec).ping(scene, pose, {}, 0).valid[1], 0) << "without multipath";
  spec.multipath = true;
  const Sonar sonar{narrow_sonar(spec), scene, pose};
  // Out and back by the surface; and out by it but straight back, at an angle that the receiver, narrow only within the
  // fan's plane, receives as well. The transmitter is narrow across the plane: the reverse path is not transmitted.
  const double across = path * std::cos(up), direct = std::hypot(across, height), middle = 0.5 * (path + direct);
  const AcousticPing ping = sonar.ping();
  EXPECT_EQ(ping.valid[1], 1);
  EXPECT_GT(ping.ranges_m[1], middle - 0.5);
  EXPECT_LT(ping.ranges_m[1], path + 0.5);
  EXPECT_EQ(ping.labels[1], kNothing);
  EXPECT_TRUE(std::isnan(ping.incidence_rad[1]));
  const double cosine = std::sin(up), other = height / direct;
  const double expected =
      sonar.solid_angle_sr() * 1e-3 *
      (cosine * sonar.lost(path) / (path * path) + std::sqrt(cosine * other) * sonar.lost(middle) / (path * direct));
  EXPECT_NEAR(10 * std::log10(sonar.energy(path - 8, path + 6, 300) / expected), 0, 0.2);
}

TEST(Ghosts, AHullOverheadReflectsAsTheSurfaceDoes) {
  AcousticSpec spec = quiet_spec();
  spec.multipath = true;
  World world = level_bed(-20);
  TriangleMesh hull = testing::box(100, 100, 1);
  for (Eigen::Vector3d& vertex : hull.vertices_m) vertex.z() -= 1.5;
  world.add_solid("hull", hull);
  spec.materials = {spec.bottom, spec.bottom, {-30, 0, nullptr, {7.8, 3.9, 0.1}}};
  const Sonar sonar{narrow_sonar(spec), RayScene(world), dipping(4, kQuarterTurn)};
  // Down 16 m; up 18 m to the hull's underside at 2 m, and down again.
  const double below = 16, path = below + 18 + 18, middle = 0.5 * (path + below);
  const auto reflected = [](const FluidBottom& fluid) {
    return std::pow(10, -0.1 * bottom_loss_db(fluid, kQuarterTurn));
  };
  const double bed = reflected(spec.bottom.fluid), plates = reflected(spec.materials[2].fluid);
  const double mirrored = 2 * bed * plates / (path * below);
  const double scattered =
      bed * bed / (middle * middle);  // by the hull itself, reached by the bed and left the same way
  const double expected = sonar.solid_angle_sr() * 1e-3 * (mirrored + scattered) * sonar.lost(middle);
  EXPECT_NEAR(10 * std::log10(sonar.energy(middle - 0.3, middle + 0.3, 8000) / expected), 0, 0.3);
}

TEST(Ghosts, LeaveThePingAsItWasWhereNoneArrives) {
  AcousticSpec spec = quiet_spec();
  spec.range_noise = spec.false_detections = true;
  const RayScene scene(level_bed(-20));
  const Pose pose = dipping(1e-3, kQuarterTurn);
  const AcousticPing before = narrow_sonar(spec, 39).ping(scene, pose, {}, 3);
  spec.multipath = true;
  const AcousticPing after = narrow_sonar(spec, 39).ping(scene, pose, {}, 3);  // the second echo is at 40 m
  EXPECT_EQ(before.ranges_m, after.ranges_m);
  EXPECT_EQ(before.intensity_db, after.intensity_db);
}

TEST(WaterColumn, VolumeReverberationAndNoiseFollowTheSonarEquation) {
  AcousticSpec spec = quiet_spec();
  spec.volume_strength_db = -60;
  const Sonar sonar{narrow_sonar(spec), RayScene(level_bed(-40)), dipping(1e-3, kQuarterTurn)};
  double expected = 0;
  const double c = sonar.cell_m();
  for (double range_m = 20 + 0.5 * c; range_m < 22; range_m += c) {
    expected += 1e-6 * sonar.solid_angle_sr() * c / (range_m * range_m) * sonar.lost(range_m);
  }
  EXPECT_NEAR(10 * std::log10(sonar.energy(20, 22, 300) / expected), 0, 0.3);
  spec.parameters.source_level_db = 160;
  const Sonar faint{narrow_sonar(spec), RayScene(level_bed(-40)), dipping(1e-3, kQuarterTurn)};
  const double cells = 20 / c, noise = std::pow(10, -0.1 * (spec.parameters.lossless_snr_db()));
  EXPECT_NEAR(10 * std::log10(faint.energy(50, 70, 30) / (cells * noise)), 0, 0.2) << "below the bed";
}

TEST(WaterColumn, ATargetReturnsItsTargetStrength) {
  AcousticSpec spec = quiet_spec();
  spec.targets = {{"fish", false, {0, 0, -15}, {0.001, 0.001, 0.001}, 1, -40, 0}};
  const Sonar sonar{narrow_sonar(spec), RayScene(level_bed(-40)), dipping(1e-3, kQuarterTurn)};
  const double expected = 1e-4 / std::pow(15, 4) * sonar.lost(15);
  EXPECT_NEAR(10 * std::log10(sonar.energy(14.8, 15.2) / expected), 0, 0.3);
  EXPECT_NEAR(sonar.ping().ranges_m[1], 15, 0.1) << "louder than the bed's echo";
}

TEST(WaterColumn, BubblesRiseAndASchoolStaysInItsEllipsoid) {
  const MovingTargets plume({"vent", true, {1, 2, -20}, {2, 2, 10}, 200, -60, 0.5}, 7);
  const Eigen::Matrix3Xd before = plume.at(100), after = plume.at(101);
  int rising = 0;
  for (Eigen::Index k = 0; k < before.cols(); ++k) {
    EXPECT_GE(before(2, k), -20);
    EXPECT_LE(before(2, k), -10);
    EXPECT_LE(std::hypot(before(0, k) - 1, before(1, k) - 2), 1.0 * (before(2, k) + 20) / 10 + 1e-9) << "in the cone";
    if (std::abs(after(2, k) - before(2, k) - 0.5) < 1e-9) ++rising;
  }
  EXPECT_GT(rising, 180) << "all but those that begin again";
  const MovingTargets school({"cod", false, {1, 2, -20}, {6, 4, 2}, 200, -38, 0}, 7);
  const Eigen::Matrix3Xd fish = school.at(5);
  const Eigen::Array3d radii(3, 2, 1);
  for (Eigen::Index k = 0; k < fish.cols(); ++k) {
    EXPECT_LE(((fish.col(k) - Eigen::Vector3d(1, 2, -20)).array() / radii).matrix().norm(), 1 + 1e-9);
  }
}

TEST(WaterColumn, IsBoundedAndTheSameForAnyNumberOfThreads) {
  AcousticSpec spec = quiet_spec();
  spec.multipath = true;
  spec.volume_strength_db = -70;
  spec.targets = {{"fish", false, {0, 0, -10}, {20, 20, 10}, 500, -40, 0}};
  MultibeamModel fan = em2040(1);  // 513 beams
  fan.range_max_m = 300;           // more than 4,096 cells
  const AcousticMultibeam sonar(fan, spec, uniform_water(), 1000, RandomStream(5, "rov/sonar"));
  const RayScene scene(level_bed(-20));
  const AcousticPing one = sonar.ping(scene, dipping(1, kQuarterTurn), {}, 3, 1, {0, true});
  const AcousticPing three = sonar.ping(scene, dipping(1, kQuarterTurn), {}, 3, 3, {0, true});
  EXPECT_EQ(one.water_column_db, three.water_column_db);
  EXPECT_EQ(one.ranges_m, three.ranges_m);
  EXPECT_LE(one.water_column_db.size(), 513 * AcousticMultibeam::kSamplesMax);
  EXPECT_GE(one.water_column_sample_m * static_cast<double>(one.water_column_db.size()) / 513, 300 - 1e-9);
  EXPECT_TRUE(sonar.ping(scene, dipping(1, kQuarterTurn), {}, 3).water_column_db.empty()) << "unless requested";
  EXPECT_EQ(sonar.ping(scene, dipping(1, kQuarterTurn), {}, 3).ranges_m, one.ranges_m);
}

}  // namespace
}  // namespace uwsim
