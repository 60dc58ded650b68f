#include "uwsim/rays/tiling.h"

#include <gtest/gtest.h>

#include <cmath>

#include "meshes.h"
#include "uwsim/rays/ray_scene.h"

namespace uwsim {
namespace {

World wide_world(std::size_t cells, double spacing_m) {
  World world;
  const std::size_t n = cells + 1;
  world.set_terrain(Heightfield(std::vector<float>(n * n, -20.0f), n, n, spacing_m, {5000, -7000}));
  return world;
}

TEST(Tiling, TilesAreAtMostAKilometreWideAndHoldEveryCellOnce) {
  for (const auto& [cells, spacing_m] : {std::pair{400, 0.5}, {1001, 1.0}, {123, 30.0}, {7, 400.0}, {3, 2500.0}}) {
    const World world = wide_world(static_cast<std::size_t>(cells), spacing_m);
    std::size_t held = 0;
    for (const TileContents& tile : cut_into_tiles(world)) {
      held += std::size_t{tile.columns} * tile.rows;
      EXPECT_LE(std::max(tile.columns, tile.rows) * spacing_m, std::max(kTileWidth_m, spacing_m));
    }
    EXPECT_EQ(held, static_cast<std::size_t>(cells) * static_cast<std::size_t>(cells));
  }
}

TEST(Tiling, EveryTriangleAndShapeIsInOneTileEvenBesideTheTerrain) {
  World world = wide_world(100, 30);
  TriangleMesh scattered;
  for (std::uint32_t k = 0; k < 500; ++k) {
    const Eigen::Vector3d at(137.0 * k - 20'000, 91.0 * (k % 17) - 7500, -10);
    scattered.triangles.push_back({3 * k, 3 * k + 1, 3 * k + 2});
    for (const Eigen::Vector3d& corner :
         {at, Eigen::Vector3d(at.x() + 1, at.y(), -10), Eigen::Vector3d(at.x(), at.y() + 1, -9)}) {
      scattered.vertices_m.push_back(corner);
    }
  }
  world.add_solid("scattered", scattered);
  world.add_solid("pipe", scattered, pipe({{4000, -6000, -20}, {6000, -6000, -20}, {9000, -5000, -20}}, 1));
  std::vector<int> triangles(500, 0), shapes(2, 0), meshes(500, 0);
  for (const TileContents& tile : cut_into_tiles(world)) {
    for (const auto& share : tile.solids) {
      for (const std::uint32_t k : share.members) ++(share.label == kTerrain + 1 ? triangles : shapes)[k];
    }
    for (const auto& share : tile.meshes) {
      for (const std::uint32_t k : share.members) ++meshes[k];
    }
  }
  EXPECT_EQ(triangles, std::vector<int>(500, 1));
  EXPECT_EQ(meshes, std::vector<int>(500, 1));
  EXPECT_EQ(shapes, std::vector<int>(2, 1));
  EXPECT_TRUE(cut_into_tiles(World{}).empty());
}

/// A bed 1 km wide and a ball of triangles with edges of about 5 cm.
World wide_world_with_fine_ball(const Eigen::Vector3d& middle) {
  World world = wide_world(200, 5);
  TriangleMesh ball = testing::sphere(1, 40);
  for (Eigen::Vector3d& v : ball.vertices_m) v += middle;
  world.add_solid("ball", ball);
  return world;
}

TEST(Tiling, ASolidOfFineTrianglesHasItsOwnTileInAWideWorld) {
  const std::vector<TileContents> tiles = cut_into_tiles(wide_world_with_fine_ball({5500, -6500, -10}));
  ASSERT_EQ(tiles.size(), 2u);
  for (const TileContents& tile : tiles) EXPECT_NE(tile.columns > 0, !tile.solids.empty());
}

TEST(Tiling, RaysMeetAFineBallAndTheBedAroundItExactly) {
  const Eigen::Vector3d middle(5500, -6500, -19.5);  // half sunk into the bed
  const RayScene scene(wide_world_with_fine_ball(middle));
  for (int k = 0; k < 400; ++k) {
    const double x = 0.006 * (k - 200), y = 0.31 * std::sin(k), off_axis = std::hypot(x, y);
    const RayHit hit = scene.cast({middle + Eigen::Vector3d(x, y, 9.5), -Eigen::Vector3d::UnitZ()}, 50);
    if (off_axis > 1) {
      EXPECT_EQ(hit.label, kTerrain);
      EXPECT_NEAR(hit.distance_m, 10, 1e-9);
    } else if (off_axis < 0.97) {
      EXPECT_EQ(hit.label, kTerrain + 1);
      EXPECT_NEAR(hit.distance_m, 9.5 - std::sqrt(1 - off_axis * off_axis), 1e-2);
    }
  }
}

}  // namespace
}  // namespace uwsim
