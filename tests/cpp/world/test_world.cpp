#include "uwsim/world/world.h"

#include <gtest/gtest.h>

#include <cmath>

#include "meshes.h"
#include "uwsim/core/check.h"

namespace uwsim {
namespace {

TEST(Heightfield, APlaneIsInterpolatedExactlyAndEndsAtTheGridsEdge) {
  std::vector<float> heights;
  for (int j = 0; j < 4; ++j) {
    for (int i = 0; i < 5; ++i) heights.push_back(static_cast<float>(0.5 * i - 0.25 * j));
  }
  const Heightfield terrain(heights, 5, 4, 2.0, {10, 20});
  for (const auto& [x, y] : {std::pair{10.0, 20.0}, {18.0, 26.0}, {13.3, 21.7}, {15.9, 25.2}}) {
    EXPECT_NEAR(terrain.height_at(x, y), 0.5 * (x - 10) / 2 - 0.25 * (y - 20) / 2, 1e-12);
  }
  EXPECT_TRUE(std::isnan(terrain.height_at(9.99, 22)));
  EXPECT_TRUE(std::isnan(terrain.height_at(12, 26.01)));
}

TEST(Heightfield, HeightsLieOnTheTriangles) {
  const Heightfield terrain({0, 1, 4, -2}, 2, 2, 1.0, {0, 0});
  for (std::size_t k = 0; k < terrain.triangle_count(); ++k) {
    const Triangle t = terrain.triangle(k);
    const Eigen::Vector3d a = terrain.vertex(t[0]), b = terrain.vertex(t[1]), c = terrain.vertex(t[2]);
    const Eigen::Vector3d middle = (a + b + c) / 3;
    EXPECT_NEAR(terrain.height_at(middle.x(), middle.y()), middle.z(), 1e-12);
    EXPECT_GT((b - a).cross(c - a).z(), 0) << "triangles face up";
  }
}

TEST(World, NonFiniteTerrainAndRepeatedNamesAreRefused) {
  EXPECT_THROW(Heightfield({0, 0, NAN, 0}, 2, 2, 1.0, {0, 0}), InvalidValue);
  EXPECT_THROW(Heightfield({0, 0}, 2, 1, 1.0, {0, 0}), InvalidValue);
  World world;
  EXPECT_EQ(world.add_solid("gate", testing::box(1, 1, 1)), kTerrain + 1);
  EXPECT_THROW(world.add_solid("gate", testing::box(1, 1, 1)), InvalidValue);
  EXPECT_THROW(world.add_solid("terrain", testing::box(1, 1, 1)), InvalidValue);
}

TEST(World, SolidAroundFindsTheClosedSolidThatEnclosesAPoint) {
  World world;
  TriangleMesh box = testing::box(2, 2, 2), ball = testing::sphere(1, 12), bowl = ball;
  for (Eigen::Vector3d& v : ball.vertices_m) v.x() += 5;
  for (Eigen::Vector3d& v : bowl.vertices_m) v.x() -= 5;
  std::erase_if(bowl.triangles, [&](const Triangle& t) { return bowl.vertices_m[t[0]].z() > 0.7; });
  world.add_solid("box", box);
  world.add_solid("ball", ball);
  world.add_solid("bowl", bowl);
  const auto name_at = [&](const Eigen::Vector3d& p) {
    const Solid* const solid = world.solid_around(p);
    return solid ? solid->name : "";
  };
  EXPECT_EQ(name_at({0.99, -0.99, 0.99}), "box");
  EXPECT_EQ(name_at({1.01, 0, 0}), "");
  EXPECT_EQ(name_at({5, 0, 0}), "ball");
  EXPECT_EQ(name_at({5.8, 0.8, 0}), "") << "inside its bounding box but outside the ball";
  EXPECT_EQ(name_at({-5, 0, 0}), "") << "an open mesh encloses nothing";
  EXPECT_NEAR(winding_number(box, {0.3, 0.2, -0.9}), 1, 1e-12);
  EXPECT_NEAR(winding_number(box, {3, 0.2, -0.9}), 0, 1e-12);
}

TEST(Water, TheSumOfCurrentsIsLimitedToTenMetresPerSecond) {
  Water water;
  water.current_world_m_s = {4, 0, 0};
  water.currents.push_back(tidal_current({0, 5.9, 0}, 44712, 0));
  EXPECT_NO_THROW(water.check());
  water.currents.push_back(gusty_current({0.1, 0, 0}, 3, 0));
  EXPECT_THROW(water.check(), InvalidValue);
  water.currents.back() = layered_current({0, 5}, {{0, 0, 0}, {0, 0.2, 0}});
  EXPECT_THROW(water.check(), InvalidValue);
  water.currents.back() = gridded_current({{0}, {0}, {0}, {0}, {{0, 0, 0.2}}});
  EXPECT_THROW(water.check(), InvalidValue);
}

TEST(Water, PressureIsHydrostaticAndTemperatureLinear) {
  Water water;
  water.compressible = false;
  water.density_kg_m3 = 1025;
  EXPECT_NEAR(water.pressure_pa(-10) - water.pressure_pa(0), 1025 * 9.80665 * 10, 1e-6);
  EXPECT_NEAR(water.pressure_pa(0), 101325, 1e-9);
  water.surface_temperature_deg_c = 16;
  water.bottom_temperature_deg_c = 6;
  water.bottom_depth_m = 20;
  EXPECT_NEAR(water.temperature_deg_c(-10), 11, 1e-12);
  EXPECT_NEAR(water.temperature_deg_c(-50), 6, 1e-12);
}

}  // namespace
}  // namespace uwsim
