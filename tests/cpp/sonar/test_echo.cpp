#include "uwsim/sonar/echo.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "uwsim/sonar/beam_footprint.h"

namespace uwsim {
namespace {

constexpr float kCell = 0.05f;

TEST(BeamEcho, WithinOneRangeCellEnergiesAddUp) {
  std::vector<RayEcho> rays(8, {20, 0.125f, kCell, 1, kTerrain});
  const BeamEcho echo = beam_echo(rays, kCell);
  EXPECT_NEAR(echo.peak, 1, 1e-6);
  EXPECT_NEAR(echo.extent_m(kCell), kCell, 1e-6);
  EXPECT_NEAR(echo.centre_range_m, 20, 1e-6);
}

TEST(BeamEcho, AnEvenlySpreadEchoPeaksAtTheEnergyInOneCell) {
  // Rays every 0.1 m, each 0.1 m wide, form a rectangular echo of 6.4 m.
  std::vector<RayEcho> rays;
  for (int k = 0; k < 64; ++k) rays.push_back({10 + 0.1f * static_cast<float>(k), 1.0f / 64, 0.2f, 0.5f, kTerrain});
  const BeamEcho echo = beam_echo(rays, kCell);
  EXPECT_NEAR(echo.energy, 1, 1e-5);
  EXPECT_NEAR(echo.extent_m(kCell), 6.4, 0.5);
  EXPECT_NEAR(echo.centre_range_m, 10 + 0.1 * 31.5, 1e-4);
}

TEST(BeamEcho, TheTwoEchoesAtAnEdgeAreNotAveraged) {
  std::vector<RayEcho> rays(5, {10, 0.2f, kCell, 0.9f, kTerrain + 1});
  for (int k = 0; k < 3; ++k) rays.push_back({14, 0.2f, kCell, 0.5f, kTerrain});
  std::reverse(rays.begin(), rays.end());
  const BeamEcho echo = beam_echo(rays, kCell);
  EXPECT_EQ(echo.label, kTerrain + 1);
  EXPECT_NEAR(echo.centre_range_m, 10, 1e-5);
  EXPECT_NEAR(echo.energy, 1, 1e-6);
  EXPECT_NEAR(echo.cosine, 0.9, 1e-6);
}

TEST(BeamEcho, TheStrongerEchoIsDetectedEvenIfItIsFarther) {
  std::vector<RayEcho> rays(2, {10, 0.2f, kCell, 0.9f, kTerrain + 1});
  for (int k = 0; k < 6; ++k) rays.push_back({14, 0.2f, kCell, 0.5f, kTerrain});
  const BeamEcho echo = beam_echo(rays, kCell);
  EXPECT_EQ(echo.label, kTerrain);
  EXPECT_NEAR(echo.centre_range_m, 14, 1e-5);
  EXPECT_NEAR(echo.energy, 1.2, 1e-6);
}

/// The echoes of a beam's rays from a plane at a given distance along its normal, in the beam's frame: x along the
/// axis, y within the fan's plane.
std::vector<RayEcho> plane_echoes(const Eigen::Vector3d& normal, double distance_m, double width_rad,
                                  const std::vector<Eigen::Vector2d>& offsets) {
  std::vector<RayEcho> rays;
  for (std::size_t k = 0; k < offsets.size(); ++k) {
    const Eigen::Vector3d direction(1, std::tan(width_rad * offsets[k].x()), std::tan(width_rad * offsets[k].y()));
    const double range_m = distance_m / normal.dot(direction.normalized());
    rays.push_back({static_cast<float>(range_m), 1, 1, 1, kTerrain, static_cast<std::uint16_t>(k)});
  }
  return rays;
}

/// The directions of the same rays, for offsets in multiples of a width.
Eigen::Matrix3Xf directions_of(double width_rad, const std::vector<Eigen::Vector2d>& offsets) {
  Eigen::Matrix3Xf directions(3, static_cast<Eigen::Index>(offsets.size()));
  for (std::size_t k = 0; k < offsets.size(); ++k) {
    const Eigen::Vector3d direction(1, std::tan(width_rad * offsets[k].x()), std::tan(width_rad * offsets[k].y()));
    directions.col(static_cast<Eigen::Index>(k)) = direction.normalized().cast<float>();
  }
  return directions;
}

TEST(AxisRange, IsExactOverAPlaneAtAnyIncidenceAndForPartOfTheRays) {
  const auto offsets = BeamFootprint::offsets(8);
  const Eigen::Matrix3Xf directions = directions_of(0.012, offsets);
  const BeamRays beam{offsets, directions, Eigen::Vector3f::UnitX()};
  for (const double incidence : {0.0, 0.7, 1.2}) {
    const Eigen::Vector3d normal(std::cos(incidence), std::sin(incidence), 0);
    std::vector<RayEcho> rays = plane_echoes(normal, 50, 0.012, offsets);
    const double expected = 50 / std::cos(incidence);
    EXPECT_NEAR(axis_range_m(rays, beam), expected, 1e-5 * expected);
    rays.erase(rays.begin() + 2);
    rays.pop_back();
    EXPECT_NEAR(axis_range_m(rays, beam), expected, 1e-5 * expected);
  }
}

TEST(AxisRange, IsUnknownWhereTheAxisIsNotAmongTheRays) {
  const auto offsets = BeamFootprint::offsets(16);
  const Eigen::Matrix3Xf directions = directions_of(0.01, offsets);
  const BeamRays beam{offsets, directions, Eigen::Vector3f::UnitX()};
  std::vector<RayEcho> one_side;
  for (const RayEcho& ray : plane_echoes({1, 0, 0}, 50, 0.01, offsets)) {
    if (offsets[ray.ray].x() > 0) one_side.push_back(ray);
  }
  ASSERT_GT(one_side.size(), 3u);
  EXPECT_TRUE(std::isnan(axis_range_m(one_side, beam)));
  EXPECT_TRUE(std::isnan(axis_range_m({one_side.data(), 2}, beam)));
}

/// The echo of an oblique plane, attenuated with range by exp(-per_m (r - r axis)); each point has an extent of
/// point_m.
BeamEcho oblique_echo(std::vector<RayEcho>& rays, double axis_m, double per_m, float point_m) {
  for (RayEcho& ray : rays) {
    ray.energy = static_cast<float>(std::exp(-per_m * (ray.range_m - axis_m)) / static_cast<double>(rays.size()));
    ray.point_m2 = point_m * point_m;
    ray.width_m = 2;
  }
  return beam_echo(rays, kCell);
}

TEST(AxisEcho, HasTheGaussiansDensityForAnyNumberOfRaysAndTheEnergyOnTheAxis) {
  constexpr double kWidth_rad = 0.012, kIncidence = 1.0;
  const Eigen::Vector3d normal(std::cos(kIncidence), std::sin(kIncidence), 0);
  const double axis_m = 50 / std::cos(kIncidence), deviation_m = kWidth_rad * axis_m * std::tan(kIncidence);
  for (const int count : {8, 16, 64}) {
    const auto offsets = BeamFootprint::offsets(count);
    const Eigen::Matrix3Xf directions = directions_of(kWidth_rad, offsets);
    const BeamRays beam{offsets, directions, Eigen::Vector3f::UnitX()};
    for (const double per_m : {0.0, 0.35}) {
      for (const float point_m : {kCell, 2.0f}) {
        std::vector<RayEcho> rays = plane_echoes(normal, 50, kWidth_rad, offsets);
        const AxisEcho echo = axis_echo(oblique_echo(rays, axis_m, per_m, point_m), beam, axis_m, kCell);
        const double extent_m = std::hypot(point_m, std::sqrt(2 * std::numbers::pi) * deviation_m);
        EXPECT_NEAR(echo.extent_m, extent_m, 0.01 * extent_m) << count;
        // Not exact, because ranges are curved over the offsets (per_m var(x) r'' / 2 = 1.4 %), and rays have no tails.
        EXPECT_NEAR(echo.level, kCell / extent_m, 0.03 * kCell / extent_m) << count << " rays, " << per_m;
      }
    }
  }
}

TEST(AxisEcho, IsTheSumOfShapesIfRaysAreMissing) {
  const auto offsets = BeamFootprint::offsets(8);
  const Eigen::Matrix3Xf directions = directions_of(0.012, offsets);
  const BeamRays beam{offsets, directions, Eigen::Vector3f::UnitX()};
  std::vector<RayEcho> rays = plane_echoes({1, 0, 0}, 50, 0.012, offsets);
  rays.resize(5);
  const BeamEcho echo = oblique_echo(rays, 50, 0, kCell);
  EXPECT_NEAR(axis_echo(echo, beam, 50, kCell).level, kCell / 2, 0.01 * kCell) << "energy 1 over a width of 2 m";
  EXPECT_NEAR(axis_echo(echo, beam, 50, kCell).extent_m, echo.extent_m(kCell), 1e-6);
}

TEST(BeamEcho, WithoutRaysThereIsNoEcho) { EXPECT_EQ(beam_echo({}, kCell).peak, 0); }

}  // namespace
}  // namespace uwsim
