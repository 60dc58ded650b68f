#include "uwsim/sonar/echo.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

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
  // Rays every 0.1 m, each 0.1 m wide: a rectangular echo of 6.4 m.
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

TEST(BeamEcho, WithoutRaysThereIsNoEcho) { EXPECT_EQ(beam_echo({}, kCell).peak, 0); }

}  // namespace
}  // namespace uwsim
