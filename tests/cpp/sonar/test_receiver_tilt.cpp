#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "uwsim/sonar/acoustic_multibeam.h"

namespace uwsim {
namespace {

World bed_40_m_below() {
  World world;
  world.set_terrain(Heightfield(std::vector<float>(4, -40.f), 2, 2, 2000, {-1000, -1000}));
  return world;
}

/// A quantity in decibels as a ratio, averaged over two beams at 60 degrees from straight down and 400 pings.
double mean_ratio(const AcousticSpec& spec, double tilt_rad, std::vector<float> AcousticPing::*level) {
  MultibeamModel fan = em2040(1);
  fan.beams = 2;
  fan.field_of_view_rad = 2 * std::numbers::pi / 3;
  fan.range_max_m = 500;
  fan.receiver_tilt_rad = tilt_rad;
  const RayScene scene(bed_40_m_below());
  const AcousticMultibeam sonar(fan, spec, Water{}, 1000, RandomStream(5, "rov/sonar"));
  const Eigen::Quaterniond down(Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitY()));
  double sum = 0;
  for (int tick = 0; tick < 400; ++tick) {
    const AcousticPing ping =
        sonar.ping(scene, {{2.0 * tick - 400, 0, -1e-3}, down}, {}, static_cast<std::uint64_t>(tick));
    for (const float each : ping.*level) sum += std::pow(10, each / 10) / 800;
  }
  return sum;
}

TEST(ReceiverTilt, HearsLessNoiseAlongTheTiltAndTheSameEcho) {
  AcousticSpec spec;
  spec.parameters.source_level_db = 230;  // every echo is detected
  spec.false_detections = false;
  spec.range_noise = false;
  const double along = std::numbers::pi / 3;
  EXPECT_NEAR(mean_ratio(spec, along, &AcousticPing::snr_db) / mean_ratio(spec, 0, &AcousticPing::snr_db), 2, 0.1);
  EXPECT_NEAR(mean_ratio(spec, along, &AcousticPing::intensity_db) / mean_ratio(spec, 0, &AcousticPing::intensity_db),
              1, 0.05);
}

}  // namespace
}  // namespace uwsim
