#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sonar/imaging_pool.h"
#include "uwsim/core/check.h"

namespace uwsim {
namespace {

using testing::at;
using testing::flat_bed;
using testing::ImagingModel;
using testing::kDegree;
using testing::quiet_single_beam;

/// The pose of a head that steps in the vertical plane, with its x axis straight down and its y axis to port.
Pose downwards(double z_m) { return at({0, 0, z_m}, 90 * kDegree); }

std::vector<float> ranges_m(const ImagingModel& model, const World& world, const Pose& pose,
                            const std::vector<double>& angles, int threads = 1) {
  return testing::values_of(model, world, {.poses = {pose}, .angles_rad = angles, .threads = threads}, "ranges_m");
}

TEST(SingleBeam, ProfilesAFlatBedAsHeightOverCosine) {
  const ImagingModel model = quiet_single_beam();
  const std::vector angles{-45 * kDegree, -20 * kDegree, 0.0, 10 * kDegree, 45 * kDegree};
  const auto ranges = ranges_m(model, flat_bed(-20), downwards(-12), angles);
  for (std::size_t k = 0; k < angles.size(); ++k) {
    const double expected = 8 / std::cos(angles[k]);
    EXPECT_NEAR(ranges[k], expected, 0.01 + expected * model["beam_width_rad"] * model["beam_width_rad"]) << k;
  }
}

TEST(SingleBeam, TheObliqueEchoIsAsLongAsTheFootprint) {
  const ImagingModel model = quiet_single_beam();
  const testing::Pings pings{.poses = {downwards(-12)}, .angles_rad = {45 * kDegree}};
  const auto levels = testing::values_of(model, flat_bed(-20), pings, "level_db");
  const float peak = *std::max_element(levels.begin(), levels.end());
  const auto half = std::count_if(levels.begin(), levels.end(), [&](float level) { return level > peak - 3.01f; });
  const double range = 8 * std::sqrt(2.0);
  EXPECT_NEAR(static_cast<double>(half) * 0.01, range * std::tan(45 * kDegree) * model["beam_width_rad"], 0.04);
}

TEST(SingleBeam, SpeckleShiftsTheRangeByLessThanTheFootprint) {
  ImagingModel model = quiet_single_beam();
  model["looks"] = 1;
  model["noise_level_db"] = 55;
  const World bed = flat_bed(-20);
  std::vector<float> ranges;
  for (int k = 0; k < 200; ++k) {
    Pose place = downwards(-12);
    place.position_m.x() = 0.5 * k;
    ranges.push_back(ranges_m(model, bed, place, {30 * kDegree}).front());
  }
  const double range = 8 / std::cos(30 * kDegree), footprint = range * std::tan(30 * kDegree) * model["beam_width_rad"];
  double mean = 0, variance = 0;
  for (const float found : ranges) {
    EXPECT_NEAR(found, range, footprint);
    mean += found / 200;
    variance += (found - range) * (found - range) / 200;
  }
  EXPECT_LT(std::sqrt(variance), 0.1 * footprint) << "the centroid averages over the footprint's bins";
  EXPECT_NEAR(mean, range, 0.02);
  const std::vector<double> angles = {-0.2, 0, 0.4};
  EXPECT_EQ(ranges_m(model, bed, downwards(-12), angles), ranges_m(model, bed, downwards(-12), angles, 3));
}

TEST(SingleBeam, WithoutAnEchoTheRangeIsInfinite) {
  ImagingModel model = quiet_single_beam();
  model["looks"] = 1;
  model["noise_level_db"] = 55;
  const std::vector angles{0.0, 80 * kDegree};
  for (const Pose& pose : {downwards(-12), downwards(1), downwards(-21)}) {
    const auto ranges = ranges_m(model, flat_bed(pose.position_m.z() == -12 ? -60 : -20), pose, angles);
    for (const float range : ranges) EXPECT_TRUE(std::isinf(range)) << range;
  }
}

TEST(SingleBeam, RefusesParametersOutOfRange) {
  const auto refused = [](auto change) {
    ImagingModel model = quiet_single_beam();
    change(model);
    EXPECT_THROW(model.make(), InvalidValue);
  };
  EXPECT_NO_THROW(quiet_single_beam().make());
  refused([](auto& m) { m["beam_width_rad"] = 0; });
  refused([](auto& m) { m["rays_across"] = 1; });
  refused([](auto& m) { m["detection_db"] = std::nan(""); });
}

TEST(SingleBeam, TheSecondEchoOfALevelBedIsAtTwiceTheRangeWithTheLevelOfItsImage) {
  ImagingModel model = quiet_single_beam();
  model["multipath"] = 1;
  model["rays_across"] = 41;
  const testing::Pings pings{.poses = {downwards(-1e-3)}, .angles_rad = {0.0}};
  const auto levels = testing::values_of(model, flat_bed(-8), pings, "level_db");
  const auto energy = [&](double from_m, double to_m) {
    double sum = 0;
    for (auto bin = static_cast<std::size_t>(from_m * 100); bin < static_cast<std::size_t>(to_m * 100); ++bin) {
      sum += std::pow(10, 0.1 * levels[bin]);
    }
    return sum;
  };
  // The image of the source is at 3 h, and its footprint, over which the pencil beam receives directly, is 9 h^2. Two
  // Gaussian patterns, one met at three times the angle, overlap by a fifth of their square's integral.
  const FluidBottom sand;
  const double reflected = std::pow(10, -0.1 * bottom_loss_db(sand, std::numbers::pi / 2));
  const double absorbed = 2 * 8 * model.acoustics().absorption_db_m(flat_bed(-8).water, -1e-3);
  const double expected_db = 10 * std::log10(2 * reflected / 5) - absorbed;
  EXPECT_NEAR(10 * std::log10(energy(15.8, 16.2) / energy(7.8, 8.2)), expected_db, 1.0);
  model["multipath"] = 0;
  const auto plain = testing::values_of(model, flat_bed(-8), pings, "level_db");
  EXPECT_LT(*std::max_element(plain.begin() + 1500, plain.begin() + 1700), testing::kSilence_db + 20);
}

}  // namespace
}  // namespace uwsim
