#include "uwsim/dynamics/broad_phase.h"

#include <gtest/gtest.h>

#include <cmath>

#include "dynamics/bodies.h"
#include "uwsim/core/random.h"

namespace uwsim {
namespace {

/// Hills, a wall next to the terrain and a bar above it.
World hilly_world() {
  std::vector<float> heights;
  for (int j = 0; j < 81; ++j) {
    for (int i = 0; i < 101; ++i) {
      heights.push_back(static_cast<float>(-20 + 4 * std::sin(0.11 * i) * std::cos(0.13 * j)));
    }
  }
  World world;
  world.set_terrain(Heightfield(heights, 101, 81, 0.7, {-30, -25}));
  world.add_solid("wall", testing::moved(testing::box(1, 30, 12), {60, 0, -10}));
  world.add_solid("bar", testing::moved(testing::box(6, 0.3, 0.3), {3, 4, -8}));
  return world;
}

TEST(BroadPhase, ItNeverMissesASurfaceInTheBox) {
  const World world = hilly_world();
  const BroadPhase broad_phase(world);
  const Heightfield& terrain = *world.terrain();
  const RandomStream draw(1, "clearance");
  int near = 0;
  for (std::uint64_t k = 0; k < 20'000; ++k) {
    const Eigen::Vector3d centre(-35 + 110 * draw.uniform(k, 0), -30 + 70 * draw.uniform(k, 1),
                                 -26 + 26 * draw.uniform(k, 2));
    const double radius = 0.05 + 6 * draw.uniform(k, 3);
    const Eigen::Vector3d reach = Eigen::Vector3d::Constant(radius);
    bool touches = false;
    for (int i = -3; i <= 3 && !touches; ++i) {
      for (int j = -3; j <= 3 && !touches; ++j) {
        const Eigen::Vector2d aside = radius / 3.0 * Eigen::Vector2d(i, j);
        const double height = terrain.height_at(centre.x() + aside.x(), centre.y() + aside.y());
        touches = height >= centre.z() - radius;
      }
    }
    for (const auto& solid : world.solids()) {
      for (const auto& v : solid->mesh_world.vertices_m) touches |= (v - centre).cwiseAbs().maxCoeff() <= radius;
    }
    near += touches;
    if (touches) {
      ASSERT_TRUE(broad_phase.may_touch(centre - reach, centre + reach)) << centre.transpose() << " r " << radius;
    }
  }
  EXPECT_GT(near, 1000);
}

TEST(BroadPhase, OpenWaterAndPlacesBesideTheWorldAreClear) {
  const BroadPhase broad_phase(hilly_world());
  EXPECT_FALSE(broad_phase.may_touch({7, -13, -8}, {13, -7, -2}));
  EXPECT_FALSE(broad_phase.may_touch({-11, 9, -15.5}, {-9, 11, -13.5}));  // half a metre above the highest hill
  EXPECT_FALSE(broad_phase.may_touch({500, 0, -30}, {510, 10, -20}));
  EXPECT_FALSE(BroadPhase(World{}).may_touch({-100, -100, -100}, {100, 100, 100}));
}

}  // namespace
}  // namespace uwsim
