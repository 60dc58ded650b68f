#include "uwsim/sonar/acoustic_multibeam.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "meshes.h"
#include "uwsim/acoustics/absorption.h"
#include "uwsim/core/check.h"

namespace uwsim {
namespace {

World bed_world(double slope, float z_m) {
  World world;
  const float rise = static_cast<float>(slope * 1000);
  world.set_terrain(Heightfield({z_m - rise, z_m + rise, z_m - rise, z_m + rise}, 2, 2, 2000, {-1000, -1000}));
  return world;
}

Water even_water() {
  Water water;
  water.surface_temperature_deg_c = water.bottom_temperature_deg_c = 8;
  return water;
}

/// Parameters with a source so loud that every echo in these tests is detected.
AcousticSpec loud() {
  AcousticSpec spec;
  spec.parameters.source_level_db = 230;
  spec.false_detections = false;
  spec.range_noise = false;
  spec.bottom.relief = 0;
  return spec;
}

MultibeamModel fan_of(int beams, double field_of_view_deg, double range_max_m = 500) {
  MultibeamModel fan = em2040(1);
  fan.beams = beams;
  fan.field_of_view_rad = field_of_view_deg * std::numbers::pi / 180;
  fan.range_max_m = range_max_m;
  return fan;
}

Pose looking_down(double depth_m) {
  return {{0, 0, -depth_m}, Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitY()))};
}

AcousticMultibeam sonar_of(const MultibeamModel& fan, const AcousticSpec& spec, const Water& water = even_water(),
                           std::uint64_t seed = 5) {
  return AcousticMultibeam(fan, spec, water, 1000, RandomStream(seed, "rov/sonar"));
}

/// The level of the middle beam's mean intensity over pings from adjacent positions, which averages out speckle.
double mean_level_db(const AcousticMultibeam& sonar, const RayScene& scene, Pose pose, int pings = 4000,
                     double apart_m = 0.45) {
  double sum = 0;
  const auto middle = static_cast<std::size_t>(sonar.fan().beams / 2);
  for (int tick = 0; tick < pings; ++tick) {
    pose.position_m.y() = apart_m * (tick - pings / 2);
    const AcousticPing ping = sonar.ping(scene, pose, {}, static_cast<std::uint64_t>(tick));
    if (ping.valid[middle]) sum += std::pow(10, ping.intensity_db[middle] / 10);
  }
  return 10 * std::log10(sum / pings);
}

TEST(AcousticMultibeam, TheLevelStraightBelowFollowsTheSonarEquation) {
  AcousticSpec spec = loud();
  spec.bottom = {-25, 0.1};
  const AcousticMultibeam sonar = sonar_of(fan_of(3, 1), spec);
  for (const float depth : {30.f, 120.f}) {
    const double absorption = absorption_db_km(spec.parameters.frequency_hz, 8, 0, 0.5 * depth) / 1000;
    const double c = sound_speed_m_s(8, 0, 0);
    const double expected =
        echo_snr_db(spec.parameters, spec.bottom, {depth}, c, absorption) - spec.parameters.lossless_snr_db();
    EXPECT_NEAR(mean_level_db(sonar, RayScene(bed_world(0, -depth)), looking_down(1e-3)), expected, 0.25) << depth;
  }
}

TEST(AcousticMultibeam, AbsorptionAppliesExactlyTwiceOnceOutAndOnceBack) {
  Water sea = even_water();
  sea.salinity_psu = 35;
  AcousticSpec spec = loud();
  spec.parameters.source_level_db = 290;  // far above the noise, which fluctuates as well
  const RayScene scene(bed_world(0, -400));
  const auto level_db = [&](double acidity_ph) {
    spec.acidity_ph = acidity_ph;  // affects only absorption
    return sonar_of(fan_of(3, 1), spec, sea).ping(scene, looking_down(1e-3), {}, 4).intensity_db[1];
  };
  const auto mean_db_m = [](double acidity_ph) {
    double sum = 0;
    for (int k = 0; k < 400; ++k) sum += absorption_db_km(400e3, 8, 35, k + 0.5, acidity_ph) / 1000 / 400;
    return sum;
  };
  EXPECT_NEAR(level_db(6) - level_db(9), 2 * 400 * (mean_db_m(9) - mean_db_m(6)), 2e-3);
  EXPECT_GT(level_db(6) - level_db(9), 0.5);
}

/// The correlation of a quantity between beams of one ping that are a given number of beams apart, over pings from many
/// positions.
template <typename Quantity>
double correlation(const AcousticMultibeam& sonar, const RayScene& scene, std::size_t apart, Quantity quantity) {
  double together = 0, alone = 0;
  for (std::uint64_t tick = 0; tick < 300; ++tick) {
    Pose pose = looking_down(1e-3);
    pose.position_m.x() = 3.0 * static_cast<double>(tick) - 450;
    const AcousticPing ping = sonar.ping(scene, pose, {}, tick);
    const std::size_t middle = ping.valid.size() / 2;
    for (std::size_t k = middle - 20; k < middle + 20; ++k) {
      together += quantity(ping, k) * quantity(ping, k + apart);
      alone += quantity(ping, k) * quantity(ping, k);
    }
  }
  return together / alone;
}

TEST(AcousticMultibeam, BeamsShareTheSpeckleOfTheGroundThatTheyShare) {
  AcousticSpec spec = loud();
  spec.range_noise = true;
  spec.parameters.beam_width_across_rad = std::numbers::pi / 180;
  const AcousticMultibeam sonar = sonar_of(fan_of(401, 96), spec);  // 0.24 degrees apart
  const RayScene scene(bed_world(0, -60));
  const auto error_m = [](const AcousticPing& ping, std::size_t k) {
    const double angle = 0.24 * std::numbers::pi / 180 * (static_cast<double>(k) - 200);
    return ping.valid[k] ? ping.ranges_m[k] - 60 / std::cos(angle) : 0.0;
  };
  EXPECT_NEAR(correlation(sonar, scene, 1, error_m), 0.92, 0.06) << "0.24 degrees apart with beams of 1 degree";
  EXPECT_NEAR(correlation(sonar, scene, 4, error_m), std::exp(-2 * std::numbers::ln2 * 0.96 * 0.96), 0.12);
  EXPECT_NEAR(correlation(sonar, scene, 20, error_m), 0, 0.1) << "no overlap";
}

TEST(AcousticMultibeam, PingsFromOnePlaceRepeatTheirSpeckleAndNotTheirNoise) {
  AcousticSpec spec = loud();
  spec.range_noise = true;
  const RayScene scene(bed_world(0, -60));
  const auto level_db = [&](const AcousticMultibeam& sonar, double x_m, std::uint64_t tick) {
    Pose pose = looking_down(1e-3);
    pose.position_m.x() = x_m;
    return sonar.ping(scene, pose, {}, tick).intensity_db;
  };
  const auto apart_db = [](const std::vector<float>& a, const std::vector<float>& b) {
    double sum = 0;
    int both = 0;
    for (std::size_t k = 0; k < a.size(); ++k) {
      if (!std::isfinite(a[k] - b[k])) continue;  // no echo
      sum += std::abs(a[k] - b[k]);
      ++both;
    }
    return sum / both;
  };
  const AcousticMultibeam clear = sonar_of(fan_of(401, 60), spec);
  spec.parameters.noise_level_db += 40;
  const AcousticMultibeam noisy = sonar_of(fan_of(401, 60), spec);
  const double by_noise = apart_db(level_db(clear, 0, 1), level_db(clear, 0, 2));
  EXPECT_LT(by_noise, 0.05) << "at a signal-to-noise ratio of some 50 dB";
  EXPECT_GT(by_noise, 0);
  EXPECT_GT(apart_db(level_db(noisy, 0, 1), level_db(noisy, 0, 2)), 5 * by_noise);
  EXPECT_GT(apart_db(level_db(clear, 0, 1), level_db(clear, 5, 1)), 0.5) << "other ground";
}

TEST(AcousticMultibeam, AnObliqueEchoFallsBy30LogRAndThatOfASmallTargetBy40) {
  AcousticSpec spec = loud();
  spec.parameters.frequency_hz = 2e3;  // almost no absorption
  spec.parameters.bandwidth_hz = 2e3;
  spec.parameters.pulse_length_s = 1e-2;
  const auto fall_db = [&](const RayScene& near, const RayScene& far, const Pose& a, const Pose& b) {
    const AcousticMultibeam sonar = sonar_of(fan_of(3, 1, 2000), spec);
    return mean_level_db(sonar, near, a) - mean_level_db(sonar, far, b);
  };
  // On a slope of 60 degrees, the footprint extends over many range cells.
  spec.parameters.beam_width_across_rad = spec.parameters.beam_width_along_rad = 0.3;
  const double steep = std::tan(std::numbers::pi / 3);
  EXPECT_NEAR(fall_db(RayScene(bed_world(steep, -100)), RayScene(bed_world(steep, -400)), looking_down(0.001),
                      looking_down(0.001)),
              30 * std::log10(4.0), 1.0);
  const auto plate = [](double z_m) {
    World world;
    TriangleMesh mesh = testing::box(4, 4, 1);
    for (auto& v : mesh.vertices_m) v += Eigen::Vector3d(0.2, 0, z_m);
    world.add_solid("plate", mesh);
    return world;
  };
  spec.rays_per_beam = 64;
  // Use 64 rays, so that enough of them hit the plate.
  spec.parameters.beam_width_across_rad = spec.parameters.beam_width_along_rad = 0.1;
  const auto level_db = [&](double z_m) {  // over many worlds, because the plate has the speckle of a single position
    const RayScene scene(plate(z_m));
    double sum = 0;
    for (std::uint64_t seed = 0; seed < 1000; ++seed) {
      const auto ping = sonar_of(fan_of(3, 1, 2000), spec, even_water(), seed).ping(scene, looking_down(0.001), {}, 0);
      if (ping.valid[1]) sum += std::pow(10, ping.intensity_db[1] / 10);
    }
    return 10 * std::log10(sum);
  };
  EXPECT_NEAR(level_db(-60) - level_db(-120), 40 * std::log10(2.0), 2.5);
}

TEST(AcousticMultibeam, TheFootprintOnASlopeAveragesToItsPlane) {
  AcousticSpec spec = loud();
  spec.parameters.beam_width_across_rad = spec.parameters.beam_width_along_rad = 0.03;
  const double slope = std::tan(0.5);
  const RayScene scene(bed_world(slope, -50));
  const AcousticPing ping = sonar_of(fan_of(3, 1), spec).ping(scene, looking_down(1e-3), {}, 0);
  ASSERT_EQ(ping.valid[1], 1);
  EXPECT_NEAR(ping.ranges_m[1], 50, 3e-3);
  EXPECT_NEAR(ping.incidence_rad[1], 0.5, 0.03);
  EXPECT_EQ(ping.labels[1], kTerrain);
}

TEST(AcousticMultibeam, ObliqueBeamsAreDetectedByPhaseWithSmallerErrorsThanByAmplitude) {
  AcousticSpec spec = loud();
  spec.range_noise = true;
  const RayScene scene(bed_world(0, -40));
  const AcousticMultibeam sonar = sonar_of(fan_of(121, 120), spec);
  double squares = 0, predicted_amplitude = 0;
  int count = 0;
  const double axis_m = 40 / std::cos(std::numbers::pi / 3);
  for (std::uint64_t tick = 0; tick < 400; ++tick) {
    Pose pose = looking_down(1e-3);
    pose.position_m.x() = static_cast<double>(tick);
    const AcousticPing ping = sonar.ping(scene, pose, {}, tick);
    EXPECT_NE(ping.detections[60], static_cast<int>(Detection::kPhase)) << "straight down";
    if (!ping.valid[0]) continue;
    EXPECT_EQ(ping.detections[0], static_cast<int>(Detection::kPhase));
    squares += std::pow(ping.ranges_m[0] - axis_m, 2);
    const double footprint_m = 0.4247 * 2.5066 * axis_m * 2 * 0.012 * std::tan(std::numbers::pi / 3);
    predicted_amplitude += std::pow(amplitude_range_deviation(footprint_m, 0.07, 1e3).total_m(), 2);
    ++count;
  }
  ASSERT_GT(count, 390);
  EXPECT_LT(std::sqrt(squares / count), 0.4 * std::sqrt(predicted_amplitude / count));
}

TEST(AcousticMultibeam, PhaseFindsTheRangeOfTheAxisWithoutBias) {
  const RayScene scene(bed_world(0, -50));
  const AcousticPing ping = sonar_of(fan_of(137, 136), loud()).ping(scene, looking_down(1e-9), {}, 0);
  for (std::size_t k = 0; k < 137; ++k) {
    if (ping.detections[k] != static_cast<int>(Detection::kPhase)) continue;
    const double angle = (static_cast<double>(k) - 68) * std::numbers::pi / 180;
    EXPECT_NEAR(ping.ranges_m[k], 50 / std::cos(angle), 2e-3) << angle;
  }
  EXPECT_EQ(ping.detections[0], static_cast<int>(Detection::kPhase)) << "68 degrees from straight below";
}

TEST(AcousticMultibeam, TheShareOfDetectionsFallsWithRangeAndIsOneHalfAtTheThreshold) {
  AcousticSpec spec;
  spec.false_detections = false;
  const Water water = even_water();
  const double c = sound_speed_m_s(8, 0, 0);
  const AcousticMultibeam sonar = sonar_of(fan_of(3, 0.2, 2000), spec, water);
  double before = 1;
  for (const float depth : {100.f, 200.f, 300.f, 400.f, 600.f}) {
    const RayScene scene(bed_world(0, -depth));
    double share = 0;
    for (int place = 0; place < 300; ++place) {
      Pose pose = looking_down(1e-3);
      pose.position_m.x() = 6.0 * (place - 150);
      share += sonar.ping(scene, pose, {}, static_cast<std::uint64_t>(place)).valid[1] / 300.0;
    }
    const double absorption = absorption_db_km(spec.parameters.frequency_hz, 8, 0, 0.5 * depth) / 1000;
    const double snr = std::pow(10, echo_snr_db(spec.parameters, spec.bottom, {depth}, c, absorption) / 10);
    const double looks =
        averaged_looks(echo_extent_m(spec.parameters, spec.bottom, {depth}, c), spec.parameters.range_cell_m(c));
    EXPECT_NEAR(share, DetectionThreshold(13).detection_probability(snr, looks), 0.12) << depth;
    EXPECT_LE(share, before);
    before = share;
  }
  EXPECT_LT(before, 0.02);
}

TEST(AcousticMultibeam, FalseDetectionsOccurAtTheirRateAndNeverWhenSwitchedOff) {
  AcousticSpec spec;
  spec.parameters.detection_threshold_db = 9;
  const RayScene empty(bed_world(0, -900));
  const MultibeamModel fan = fan_of(301, 20, 400);
  int count = 0;
  for (std::uint64_t tick = 0; tick < 40; ++tick) {
    const AcousticPing ping = sonar_of(fan, spec).ping(empty, looking_down(1), {}, tick);
    for (std::size_t k = 0; k < 301; ++k) {
      if (!ping.valid[k]) continue;
      ++count;
      EXPECT_EQ(ping.detections[k], static_cast<int>(Detection::kFalse));
      EXPECT_EQ(ping.labels[k], kNothing);
      EXPECT_TRUE(ping.ranges_m[k] > 0 && ping.ranges_m[k] < 400 && std::isfinite(ping.points_sonar_m[3 * k]));
    }
  }
  const double cells = 400 / (0.5 * sound_speed_m_s(8, 0, 1) / 1e4);
  const double rate = 1 - std::pow(1 - DetectionThreshold(9).false_alarm(), cells);
  EXPECT_NEAR(count, 40 * 301 * rate, 4 * std::sqrt(40 * 301 * rate));
  spec.false_detections = false;
  for (std::uint64_t tick = 0; tick < 40; ++tick) {
    for (const auto valid : sonar_of(fan, spec).ping(empty, looking_down(1), {}, tick).valid) EXPECT_EQ(valid, 0);
  }
}

TEST(AcousticMultibeam, AMovingHeadReceivesTheEchoAtItsNewPose) {
  const RayScene scene(bed_world(0, -100));
  const AcousticMultibeam sonar = sonar_of(fan_of(121, 90), loud());
  const Pose pose = looking_down(1e-3);
  const auto range_m = [&](const HeadMotion& motion, std::size_t beam) {
    return sonar.ping(scene, pose, motion, 0).ranges_m[beam];
  };
  const double c = sound_speed_m_s(8, 0, 0), under_way_s = 200 / c;
  const double at_rest = range_m({}, 60);
  EXPECT_NEAR(range_m({{0, 0, -5}, {0, 0, 0}}, 60), at_rest - 0.5 * 5 * under_way_s, 2e-3);
  EXPECT_NEAR(range_m({{5, 0, 0}, {0, 0, 0}}, 60), at_rest, 2e-3) << "no first-order effect of motion across the path";
  // The fan lies in y-z: rotation about x turns beam 0 from its 45 degrees before reception.
  const double rate = 0.3;
  const double still = range_m({}, 0), turned = range_m({{0, 0, 0}, {rate, 0, 0}}, 0);
  const double turn = rate * 2 * still / c;
  const double sign = turned > still ? 1 : -1;
  EXPECT_NEAR(turned, 100 / std::cos(std::numbers::pi / 4 + sign * turn), 0.15);
  EXPECT_NEAR(range_m({{0, 0, 0}, {-rate, 0, 0}}, 0), 100 / std::cos(std::numbers::pi / 4 - sign * turn), 0.15);
}

TEST(AcousticMultibeam, APingIsTheSameForAnyNumberOfThreads) {
  AcousticSpec spec;
  spec.parameters.source_level_db = 195;
  const RayScene scene(bed_world(0.2, -80));
  for (const bool bending : {false, true}) {
    spec.bending = bending;
    Water water = even_water();
    water.surface_temperature_deg_c = 18;
    const AcousticMultibeam sonar = sonar_of(fan_of(1025, 120), spec, water);
    const HeadMotion motion{{1, 0.5, 0}, {0.1, 0, 0}};
    const AcousticPing one = sonar.ping(scene, looking_down(2), motion, 9, 1);
    const AcousticPing two = sonar.ping(scene, looking_down(2), motion, 9, 2);
    EXPECT_EQ(one.ranges_m, two.ranges_m);
    EXPECT_EQ(one.intensity_db, two.intensity_db);
    EXPECT_EQ(one.detections, two.detections);
    EXPECT_NE(one.ranges_m, sonar.ping(scene, looking_down(2), motion, 10).ranges_m) << "another tick";
  }
}

TEST(AcousticMultibeam, EachLabelHasItsStrength) {
  AcousticSpec spec = loud();
  spec.materials = {{-30, 0}, {-42, 0}};
  spec.bottom = {-20, 0};
  const RayScene scene(bed_world(0, -30));
  const double soft = mean_level_db(sonar_of(fan_of(3, 1), spec), scene, looking_down(1e-3));
  spec.materials.clear();
  EXPECT_NEAR(mean_level_db(sonar_of(fan_of(3, 1), spec), scene, looking_down(1e-3)) - soft, 22, 0.5);
}

TEST(AcousticMultibeam, BendingChangesTravelTimesAndKeepsTheNominalBeamAngles) {
  Water water = even_water();
  water.surface_temperature_deg_c = 20;
  water.bottom_temperature_deg_c = 5;
  water.bottom_depth_m = 50;
  AcousticSpec spec = loud();
  const RayScene scene(bed_world(0, -50));
  const AcousticPing straight = sonar_of(fan_of(121, 120), spec, water).ping(scene, looking_down(0.5), {}, 3);
  spec.bending = true;
  const AcousticPing bent = sonar_of(fan_of(121, 120), spec, water).ping(scene, looking_down(0.5), {}, 3);
  // Sound is slower below, so the travel time is longer, and rays bend towards the bottom, so outer beams hit it
  // sooner.
  EXPECT_GT(bent.travel_time_s[60], straight.travel_time_s[60]);
  EXPECT_LT(bent.travel_time_s[0], straight.travel_time_s[0]);
}

TEST(AcousticMultibeam, AHeadAboveTheWaterOrUnderTheGroundDetectsNothing) {
  const RayScene scene(bed_world(0, -30));
  for (const double depth_m : {-1.0, 30.5}) {
    const AcousticPing ping = sonar_of(fan_of(31, 90), {}).ping(scene, looking_down(depth_m), {}, 0);
    for (std::size_t k = 0; k < 31; ++k) {
      EXPECT_EQ(ping.valid[k], 0);
      EXPECT_TRUE(std::isinf(ping.ranges_m[k]));
    }
  }
}

TEST(AcousticMultibeam, RefusesParametersOutOfRange) {
  AcousticSpec spec;
  spec.materials = {{-30, -1}};
  EXPECT_THROW(sonar_of(fan_of(3, 1), spec), InvalidValue);
  spec = {};
  spec.rays_per_beam = 2;
  EXPECT_THROW(sonar_of(fan_of(3, 1), spec), InvalidValue);
  spec = {};
  spec.acidity_ph = 14;
  EXPECT_THROW(sonar_of(fan_of(3, 1), spec), InvalidValue);
}

}  // namespace
}  // namespace uwsim
