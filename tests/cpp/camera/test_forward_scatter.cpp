#include "uwsim/camera/forward_scatter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

namespace uwsim {
namespace {

constexpr int kWidth = 192, kHeight = 128;
constexpr double kPixel_rad = 1.0 / 300;

Optics murky() {
  Optics optics;
  optics.water = jerlov_water("3C");
  optics.forward_scatter_rad = 0.03;
  return optics;
}

/// Particles' scattering of green [1/m].
double green_b(const Optics& optics) { return (optics.water.scattering - molecular_scattering())(1); }

template <typename Light, typename Path>
std::vector<float> added_green(const Optics& optics, const Light& light, const Path& path_m) {
  DirectLight direct;
  constexpr std::size_t kPixels = std::size_t{kWidth} * kHeight;
  for (auto& band : direct.bands) band.resize(kPixels);
  direct.path_m.resize(kPixels);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const auto at = static_cast<std::size_t>(v * kWidth + u);
      for (auto& band : direct.bands) band[at] = static_cast<float>(light(u, v));
      direct.path_m[at] = static_cast<float>(path_m(u, v));
    }
  }
  std::array<std::vector<float>, 3> picture;
  for (auto& band : picture) band.assign(kPixels, 0);
  add_forward_scatter(direct, kWidth, kHeight, kPixel_rad, optics, {picture[0], picture[1], picture[2]}, 2);
  return picture[1];
}

TEST(ForwardScatter, AnEvenSurfaceLosesByAbsorptionAlone) {
  const Optics optics = murky();
  const std::vector<float> added = added_green(
      optics, [](int, int) { return 0.2; }, [](int, int) { return 3.0; });
  for (const float light : added) ASSERT_NEAR(light, 0.2 * std::expm1(3 * green_b(optics)), 1e-4);
}

TEST(ForwardScatter, AGratingLosesContrastByTheTransferFunction) {
  const Optics optics = murky();
  const double path_m = 4, depth = path_m * green_b(optics);
  for (const int period : {8, 16, 32}) {  // of pixels; the margins continue it
    const double turn = 2 * std::numbers::pi / period;
    const std::vector<float> added = added_green(
        optics, [&](int u, int) { return 1 + std::cos(turn * (u + 0.5)); }, [&](int, int) { return path_m; });
    double amplitude = 0;
    for (int u = 32; u < 160; ++u) {
      amplitude += added[static_cast<std::size_t>(64 * kWidth + u)] * std::cos(turn * (u + 0.5)) / 64;
    }
    const double x = 2 * std::numbers::pi * optics.forward_scatter_rad / (period * kPixel_rad);
    EXPECT_NEAR(amplitude, std::expm1(depth * -std::expm1(-x) / x), 0.03 * std::expm1(depth)) << period;
  }
}

TEST(ForwardScatter, EnergyIsKeptWhereThePathChangesAndNoneComesFromOpenWater) {
  const Optics optics = murky();
  const auto path_m = [](int u, int) { return u < 60 ? 1.0 + 0.02 * u : u < 130 ? 5.0 : 2e4; };
  const auto light = [](int u, int v) { return u > 40 && u < 110 && v > 30 && v < 90 ? 0.5 : 0.0; };
  double expected = 0, got = 0;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < 130; ++u) expected += light(u, v) * std::expm1(green_b(optics) * path_m(u, v));
  }
  for (const float each : added_green(optics, light, path_m)) got += each;
  EXPECT_NEAR(got, expected, 0.07 * expected) << "some leaves the picture";
}

TEST(ForwardScatter, OpenWaterHasNone) {
  for (const float light : added_green(
           murky(), [](int, int) { return 0.1; }, [](int, int) { return 2e4; })) {
    ASSERT_EQ(light, 0);
  }
}

}  // namespace
}  // namespace uwsim
