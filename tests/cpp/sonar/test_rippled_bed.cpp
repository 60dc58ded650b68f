#include "uwsim/sonar/rippled_bed.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "sonar/imaging_pool.h"

namespace uwsim {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

/// Backscatter by Lambert's law of a facet with a slope along x, met by a ray in the plane of x and z.
double scattered(double slope, double incidence_rad) {
  const double cosine = (std::cos(incidence_rad) - slope * std::sin(incidence_rad)) / std::hypot(1.0, slope);
  return cosine > 0 ? cosine * cosine : 0;
}

struct Means {
  double patches, slopes;  // the mean over patches, and of Lambert's law over the slopes of the ripples there
};
Means means(double incidence_rad, double patch_m) {
  const RippledBed bed(0);
  const SandRipples ripples(0);
  const Eigen::Vector3d way(std::sin(incidence_rad), 0, -std::cos(incidence_rad));
  Means sum{0, 0};
  constexpr int kPlaces = 20000, kPhases = 64;
  for (int k = 0; k < kPlaces; ++k) {
    const Eigen::Vector3d point(0.0137 * k, 0.731 * (k % 97), -8);
    const auto [one, other] = bed.facets({point, {0, 0, 2}, way, patch_m, patch_m});
    sum.patches += 0.5 * (one * one + other * other) / kPlaces;
    const double amplitude = ripples.at(point).amplitude;
    for (int phase = 0; phase < kPhases; ++phase) {
      sum.slopes += scattered(amplitude * std::cos(kTurn * phase / kPhases), incidence_rad) / (kPlaces * kPhases);
    }
  }
  return sum;
}

TEST(RippledBed, TheMeanOverManyPatchesIsTheLawAveragedOverTheSlopes) {
  for (const double incidence_rad : {0.0, 0.4, 0.8}) {
    const Means fine = means(incidence_rad, 0.01);
    EXPECT_NEAR(fine.patches, fine.slopes, 0.01 * fine.slopes) << "followed, at " << incidence_rad;
    const Means coarse = means(incidence_rad, 3);
    EXPECT_NEAR(coarse.patches, coarse.slopes, 0.02 * coarse.slopes) << "averaged, at " << incidence_rad;
  }
}

TEST(RippledBed, RipplesFinerThanAPatchAndSteepBedsShowNoStripes) {
  const RippledBed bed(0);
  const Eigen::Vector3d way = Eigen::Vector3d(1, 0, -1).normalized();
  double least = 1, most = 0;
  for (int k = 0; k < 50; ++k) {
    const auto [one, other] = bed.facets({{0.01 * k, 0, -8}, {0, 0, 1}, way, 0.002, 3});
    least = std::min(least, one), most = std::max(most, one);
    EXPECT_NEAR(one, other, 1e-2);
    const auto across = bed.facets({{0.01 * k, 0, -8}, {0, 0, 1}, way, 3, 0.01});
    EXPECT_GT(std::abs(across[1] - across[0]), 0.1) << "the ray's long side lies across the crests";
    const auto steep = bed.facets({{0.01 * k, 0, -8}, {-0.8, 0, 0.6}, way, 0.01, 0.01});
    EXPECT_DOUBLE_EQ(steep[0], steep[1]);
  }
  EXPECT_GT(most - least, 0.2);
}

/// The wave number [1/m] at which levels over evenly spaced places vary most.
double strongest(const std::vector<double>& levels, double step_m) {
  double mean = 0, best = 0, found = 0;
  for (const double level : levels) mean += level / static_cast<double>(levels.size());
  for (double per_m = 0.5; per_m < 8; per_m += 0.02) {
    double real = 0, imaginary = 0;
    for (std::size_t k = 0; k < levels.size(); ++k) {
      const double angle = kTurn * per_m * step_m * static_cast<double>(k);
      real += (levels[k] - mean) * std::cos(angle), imaginary += (levels[k] - mean) * std::sin(angle);
    }
    if (std::hypot(real, imaginary) > best) best = std::hypot(real, imaginary), found = per_m;
  }
  return found;
}

TEST(RippledBed, ASideScanShowsStripesAtTheRipplesLength) {
  testing::ImagingModel model = testing::quiet("side_scan", 16, 1600);
  model["along_width_rad"] = 0.5 * testing::kDegree;
  model["vertical_width_rad"] = 60 * testing::kDegree;
  model["depression_rad"] = 30 * testing::kDegree;
  model["planes"] = 3;
  model["detection_db"] = 12;
  const World world = testing::flat_bed(-6);
  const RayScene scene(world);
  const RandomStream random(7, "imaging");
  const auto port = [&](std::optional<double> ripples_rad) {
    BottomMaterial bed;
    bed.strength_db = -30, bed.ripples_rad = ripples_rad;
    const auto sonar = imaging_sonar(model.kind, model.parameters, {}, {BottomMaterial{}, bed});
    const std::vector poses{testing::at({0, 0, -2})};
    const std::vector<double> angles;
    return sonar->ping({scene, world.water, poses, angles, random, 0, 1, false}).front().values;
  };
  const auto flat = port(std::nullopt), along = port(std::numbers::pi / 2);  // crests along the track
  std::vector<double> ratios;
  constexpr double kStep_m = 0.02;
  for (double across_m = 6; across_m < 15; across_m += kStep_m) {
    const auto bin = static_cast<std::size_t>(std::hypot(across_m, 4.0) / 0.01);
    ratios.push_back(double{along[bin]} - double{flat[bin]});
  }

  EXPECT_NEAR(strongest(ratios, kStep_m), 1 / double{kRipple_m}, 0.3 / double{kRipple_m});
}

}  // namespace
}  // namespace uwsim
