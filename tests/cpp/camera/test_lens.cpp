#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "uwsim/camera/lens.h"

namespace uwsim {
namespace {

Lens plumb_bob() {
  Lens lens;
  lens.fx = 400, lens.fy = 410, lens.cx = 300, lens.cy = 190;
  lens.k1 = -0.21, lens.k2 = 0.06, lens.p1 = 0.002, lens.p2 = -0.0015, lens.k3 = -0.008;
  return lens;
}

Lens rational() {
  Lens lens = plumb_bob();
  lens.k1 = 0.93, lens.k2 = 0.166, lens.k3 = 0.003;
  lens.k4 = 1.33, lens.k5 = 0.436, lens.k6 = 0.028;
  return lens;
}

Lens fisheye() {
  Lens lens;
  lens.fx = lens.fy = 240, lens.cx = 320, lens.cy = 170;
  lens.k1 = -0.03, lens.k2 = 0.02, lens.k3 = -0.03, lens.k4 = 0.016;
  lens.is_equidistant = true;
  return lens;
}

TEST(LensModels, APixelsRayIsProjectedOntoIt) {
  for (const Lens& lens : {plumb_bob(), rational(), fisheye()}) {
    EXPECT_EQ(ray_table(lens, true).folded, 0u);
    for (int v = 0; v < lens.height; v += 29) {
      for (int u = 0; u < lens.width; u += 31) {
        const auto ray = unproject(lens, {u, v});
        ASSERT_TRUE(ray && shows(lens, *ray)) << u << ' ' << v;
        EXPECT_LT((project(lens, *ray) - Eigen::Vector2d(u, v)).norm(), 1e-9) << u << ' ' << v;
      }
    }
  }
}

TEST(LensModels, AnEquidistantLensShowsEqualAnglesAtEqualDistances) {
  Lens lens = fisheye();
  lens.k1 = lens.k2 = lens.k3 = lens.k4 = 0;
  for (const double angle : {0.1, 0.7, 1.5}) {
    EXPECT_NEAR(project(lens, {std::tan(angle), 0}).x() - lens.cx, lens.fx * angle, 1e-9);
  }
  EXPECT_FALSE(unproject(lens, {lens.cx + lens.fx * std::numbers::pi / 2, lens.cy})) << "it is 90 degrees away";
}

TEST(LensModels, BeyondAFoldRaysContinueOutwards) {
  Lens lens;
  lens.fx = lens.fy = 400;
  lens.k1 = -0.2;
  const double r = std::sqrt(1 / 0.6), fold = 400 * r * (1 - 0.2 * r * r);  // where d r' / d r is 0: 344 pixels
  EXPECT_TRUE(unproject(lens, {lens.cx + fold - 1, lens.cy}));
  EXPECT_FALSE(unproject(lens, {lens.cx + fold + 1, lens.cy}));
  EXPECT_FALSE(shows(lens, {1.1 * r, 0}));
  lens.width = 900, lens.height = 1;
  lens.cx = 450, lens.cy = 0;
  const RayTable table = ray_table(lens, true);
  EXPECT_NEAR(static_cast<double>(table.folded), 2 * (450 - fold), 2);
  for (std::size_t u = 1; u < table.x.size(); ++u) EXPECT_GT(table.x[u], table.x[u - 1]) << u;
  EXPECT_NEAR(table.x[0], -(r + (450 - fold) / 400), 0.05);
}

}  // namespace
}  // namespace uwsim
