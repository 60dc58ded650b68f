#include "uwsim/rays/ray_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "meshes.h"
#include "uwsim/core/random.h"

namespace uwsim {
namespace {

World slope_world(const Eigen::Vector2d& origin_m) {
  std::vector<float> heights;
  for (int j = 0; j < 101; ++j) {
    for (int i = 0; i < 101; ++i) heights.push_back(-20 + 0.25f * static_cast<float>(i));
  }
  World world;
  world.set_terrain(Heightfield(heights, 101, 101, 1.0, origin_m));
  return world;
}

TEST(RayScene, ARayMeetsAPlaneAtTheClosedFormDistanceEvenFarFromTheOrigin) {
  for (const double offset : {0.0, 10'000.0}) {
    const RayScene scene(slope_world({offset, offset}));
    const Eigen::Vector3d origin(offset + 40.37, offset + 51.91, 0);
    for (int k = 0; k < 50; ++k) {
      const double turn = 0.3 + k * 0.11;
      const Eigen::Vector3d direction = Eigen::Vector3d(0.4 * std::cos(turn), 0.4 * std::sin(turn), -1).normalized();
      const RayHit hit = scene.cast({origin, direction}, 100);
      // z = -20 + (x - offset) / 4 along the ray
      const double expected = (20 - 0.25 * (origin.x() - offset)) / (0.25 * direction.x() - direction.z());
      EXPECT_NEAR(hit.distance_m, expected, 1e-9);
      EXPECT_EQ(hit.label, kTerrain);
      EXPECT_NEAR(hit.normal_world.z(), 1 / std::sqrt(1 + 0.0625), 1e-6);
    }
  }
}

TEST(RayScene, RaysAtVerticesAndEdgesDoNotLeakThrough) {
  const RayScene scene(slope_world({0, 0}));
  for (int j = 1; j < 100; ++j) {
    for (int i = 1; i < 100; ++i) {
      EXPECT_EQ(scene.cast({{double(i), double(j), 10}, {0, 0, -1}}, 100).label, kTerrain);
      EXPECT_EQ(scene.cast({{i + 0.5, j + 0.5, 10}, {0, 0, -1}}, 100).label, kTerrain);
    }
  }
}

TEST(RayScene, AMissIsInfinitelyFarAndLabelsTellSolidsApart) {
  World world = slope_world({0, 0});
  TriangleMesh box = testing::box(2, 2, 2);
  for (auto& v : box.vertices_m) v += Eigen::Vector3d(20, 50, -5);
  const Label label = world.add_solid("box", box);
  const RayScene scene(world);
  const RayHit hit = scene.cast({{20, 50, 0}, {0, 0, -1}}, 100);
  EXPECT_EQ(hit.label, label);
  EXPECT_NEAR(hit.distance_m, 4, 1e-12);
  EXPECT_EQ(scene.cast({{20, 50, 0}, {0, 0, -1}}, 3).distance_m, std::numeric_limits<double>::infinity());
  EXPECT_EQ(scene.cast({{20, 50, 0}, {0, 0, 1}}, 1000).label, kNothing);
}

TEST(RayScene, AWorldMadeAfterAnotherHasItsOwnSurfaces) {
  const auto depth_m = [](float heights_m, double box_top_m, double x_m) {
    World world;
    world.set_terrain(Heightfield(std::vector<float>(101 * 101, heights_m), 101, 101, 1.0, {0, 0}));
    TriangleMesh box = testing::box(2, 2, 2);
    for (auto& v : box.vertices_m) v += Eigen::Vector3d(20, 50, box_top_m - 1);
    world.add_solid("box", box);
    return RayScene(world).cast({{x_m, 50, 0}, {0, 0, -1}}, 100).distance_m;
  };
  const float lower_m = std::nextafter(-20.0f, -30.0f);
  for (int again = 0; again < 2; ++again) {
    EXPECT_EQ(depth_m(-20, -5, 40), 20);
    EXPECT_EQ(depth_m(lower_m, -5, 40), -double{lower_m});
    EXPECT_EQ(depth_m(-20, -5, 20), 5);
    EXPECT_EQ(depth_m(-20, -6, 20), 6);
  }
}

TEST(RayScene, DistanceToASphereIsRadialWhateverTheNumberOfThreads) {
  World world;
  world.add_solid("sphere", testing::sphere(2, 100));
  const RayScene scene(world);
  std::vector<Eigen::Vector3d> points;
  for (int k = 0; k < 4000; ++k) {
    points.emplace_back(5 * std::cos(k * 0.1), 5 * std::sin(k * 0.1), 0.0025 * k - 5);
  }
  std::vector<double> one(points.size()), two(points.size());
  scene.distance(points, one, 1);
  scene.distance(points, two, 2);
  EXPECT_EQ(one, two);
  // Facets are pi/100 wide in both directions, each of which contributes a sag of r (1 - cos(pi/200)).
  const double facet_sag_m = 2 * 2 * (1 - std::cos(std::numbers::pi / 200)) + 1e-6;
  for (std::size_t k = 0; k < points.size(); ++k) {
    EXPECT_NEAR(one[k], std::abs(points[k].norm() - 2), facet_sag_m);
  }
}

TEST(RayScene, TrianglesWithoutAreaDoNotSpoilDistances) {
  World world;
  world.add_solid("sliver",
                  {{{0, 0, 0}, {0, 0, 0}, {1, 0, 0}, {4, 0, 0}, {5, 0, 0}, {4, 1, 0}}, {{0, 1, 2}, {3, 4, 5}}});
  const std::vector<Eigen::Vector3d> points = {{0.5, 0, 1}, {-1, 0, 0}, {4.2, 0.2, 3}};
  std::vector<double> distances(points.size());
  RayScene(world).distance(points, distances);
  EXPECT_NEAR(distances[0], 1, 1e-9);
  EXPECT_NEAR(distances[1], 1, 1e-9);
  EXPECT_NEAR(distances[2], 3, 1e-9);
}

TEST(RayScene, PacketsMeetWhatSingleRaysMeetAndIdleLanesAreNeverBlocked) {
  World world = slope_world({0, 0});
  TriangleMesh box = testing::box(2, 2, 2);
  for (auto& v : box.vertices_m) v += Eigen::Vector3d(20, 50, -5);
  world.add_solid("box", box);
  const RayScene scene(world);
  const Eigen::Vector3d anchor(20.3, 49.7, -1);
  RayPacket rays;
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    const Eigen::Vector3f direction = Eigen::Vector3f(0.2f * static_cast<float>(k) - 1.2f, 0.1f, -1).normalized();
    rays.origin_x[k] = rays.origin_y[k] = rays.origin_z[k] = 0.01f * static_cast<float>(k);
    rays.direction_x[k] = direction.x();
    rays.direction_y[k] = direction.y();
    rays.direction_z[k] = direction.z();
    rays.near_m[k] = 0;
    rays.far_m[k] = k == 7 ? 1.0f : 100.0f;
    rays.active[k] = k == 3 ? 0 : -1;
  }
  for (const RayOrder order : {RayOrder::kIncoherent, RayOrder::kCoherent}) {
    HitPacket hits;
    std::array<std::int32_t, kPacketRays> blocked;
    scene.cast(anchor, rays, hits, order);
    scene.occluded(anchor, rays, blocked, order);
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      if (k == 3) {
        EXPECT_EQ(blocked[k], 0);
        continue;
      }
      const Eigen::Vector3d origin = anchor + 0.01 * static_cast<double>(k) * Eigen::Vector3d::Ones();
      const Eigen::Vector3d direction(rays.direction_x[k], rays.direction_y[k], rays.direction_z[k]);
      const RayHit alone = scene.cast({origin, direction}, rays.far_m[k]);
      EXPECT_EQ(hits.label[k], alone.label) << k;
      EXPECT_EQ(blocked[k], alone.label == kNothing ? 0 : -1) << k;
      if (alone.label == kNothing) {
        EXPECT_TRUE(std::isinf(hits.distance_m[k]));
        continue;
      }
      EXPECT_NEAR(hits.distance_m[k], alone.distance_m, 1e-4) << k;
      const Eigen::Vector3f normal(hits.normal_x[k], hits.normal_y[k], hits.normal_z[k]);
      EXPECT_LT((normal.normalized() - alone.normal_world).norm(), 1e-5) << k;
    }
  }
}

TEST(RayScene, RaysFromFarBeyondTheWorldAndNonFiniteRaysMeetNothing) {
  const RayScene scene(slope_world({0, 0}));
  EXPECT_EQ(scene.cast({{0, 0, 2e18}, {0, 0, -1}}, 1e30).label, kNothing);
  EXPECT_EQ(scene.cast({{0, 0, 10}, {0, 0, NAN}}, 100).label, kNothing);
}

TEST(RayScene, PacketsFindHitsInAllTilesOfAWideWorldAlsoFromFarAway) {
  // A slope 5 km long, divided into tiles, seen from inside and from 20 km above.
  std::vector<float> heights;
  for (int j = 0; j < 51; ++j) {
    for (int i = 0; i < 51; ++i) heights.push_back(-20 + 25 * static_cast<float>(i));
  }
  World world;
  world.set_terrain(Heightfield(heights, 51, 51, 100.0, {1000, 2000}));
  const RayScene scene(world);
  for (const double z : {1500.0, 20'000.0}) {
    const Eigen::Vector3d anchor(3030, 4040, z);
    RayPacket rays;
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      const Eigen::Vector3f direction = Eigen::Vector3f(0.01f * static_cast<float>(k), 0.02f, -1).normalized();
      rays.origin_x[k] = rays.origin_y[k] = rays.origin_z[k] = 0;
      rays.direction_x[k] = direction.x();
      rays.direction_y[k] = direction.y();
      rays.direction_z[k] = direction.z();
      rays.near_m[k] = 0;
      rays.far_m[k] = k == 5 ? 10.0f : 1e6f;
      rays.active[k] = k == 3 ? 0 : -1;
    }
    HitPacket hits;
    Blocked blocked;
    scene.cast(anchor, rays, hits);
    scene.occluded(anchor, rays, blocked);
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      EXPECT_EQ(blocked[k], k == 3 || k == 5 ? 0 : -1) << k;
      if (k == 3 || k == 5) continue;
      const double expected = (z - (-20 + 0.25 * (3030 - 1000))) / (0.25 * rays.direction_x[k] - rays.direction_z[k]);
      EXPECT_NEAR(hits.distance_m[k], expected, 1e-7 * expected + 1e-3) << k;
      EXPECT_EQ(hits.label[k], kTerrain);
    }
  }
}

/// Rays from the anchor, up to 1 km long.
RayPacket packet_of(const std::array<Eigen::Vector3f, kPacketRays>& directions, float near_m) {
  RayPacket rays;
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    rays.origin_x[k] = rays.origin_y[k] = rays.origin_z[k] = 0;
    rays.direction_x[k] = directions[k].x();
    rays.direction_y[k] = directions[k].y();
    rays.direction_z[k] = directions[k].z();
    rays.near_m[k] = near_m;
    rays.far_m[k] = 1000;
    rays.active[k] = -1;
  }
  return rays;
}

TEST(RayScene, ShadowRaysFromTheFootOfACliffAreBlockedByTheCliffAlone) {
  // A step of 12 m within one cell of half a metre, in a terrain 300 m wide.
  std::vector<float> heights;
  for (int j = 0; j < 601; ++j) {
    for (int i = 0; i < 601; ++i) heights.push_back(i <= 300 ? -30.0f : -18.0f);
  }
  World world;
  world.set_terrain(Heightfield(heights, 601, 601, 0.5, {0, 0}));
  const RayScene scene(world);
  for (const double off_m : {0.002, 0.02, 0.1, 0.4}) {
    std::array<Eigen::Vector3f, kPacketRays> directions;
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      const double dip = 0.3 + 0.08 * static_cast<double>(k), side = k % 2 == 0 ? 1 : -1;
      directions[k] = Eigen::Vector3d(side * std::cos(dip), 0.1, std::sin(dip)).normalized().cast<float>();
    }
    const Eigen::Vector3d anchor(150 - off_m, 150.2, -30 + 1e-3);
    Blocked blocked;
    scene.occluded(anchor, packet_of(directions, 1e-3f), blocked);
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      const RayHit exact = scene.cast({anchor, directions[k].cast<double>()}, 1000);
      EXPECT_EQ(blocked[k] != 0, exact.label == kTerrain) << off_m << " m off, ray " << k;
      EXPECT_EQ(exact.label == kTerrain, k % 2 == 0 && std::atan(24.0) > 0.3 + 0.08 * static_cast<double>(k)) << k;
    }
  }
}

TEST(RayScene, ShadowRaysAreBlockedWhereExactRaysMeetSomething) {
  const RandomStream random(3, "bed");
  std::vector<float> heights(101 * 101);
  for (std::size_t k = 0; k < heights.size(); ++k) heights[k] = static_cast<float>(-20 + 2 * random.normal(k));
  World world;
  world.set_terrain(Heightfield(heights, 101, 101, 2.0, {0, 0}));
  world.add_solid("ball", testing::sphere(6, 12));
  const RayScene scene(world);
  int differ = 0, met = 0;
  for (std::uint64_t n = 0; n < 2000; ++n) {
    std::array<Eigen::Vector3f, kPacketRays> directions;
    for (std::uint64_t k = 0; k < kPacketRays; ++k) {
      const std::uint64_t tick = n * kPacketRays + k;
      directions[k] = Eigen::Vector3d(random.normal(tick, 1), random.normal(tick, 2), 0.2 * random.normal(tick, 3))
                          .normalized()
                          .cast<float>();
    }
    const Eigen::Vector3d anchor(200 * random.uniform(n, 4), 200 * random.uniform(n, 5), -12 - random.uniform(n, 6));
    Blocked blocked;
    scene.occluded(anchor, packet_of(directions, 0), blocked);
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      const bool exact = scene.cast({anchor, directions[k].cast<double>().normalized()}, 1000).label != kNothing;
      met += exact;
      differ += exact != (blocked[k] != 0);
    }
  }
  EXPECT_GT(met, 8'000);
  EXPECT_LT(met, 22'000);
  EXPECT_LE(differ, 3) << "of 32000: at silhouettes";
}

TEST(RayScene, FloatRaysSeeASliversTipEndWhereItEnds) {
  TriangleMesh sliver;
  sliver.vertices_m = {{0, 0, -10},       {20, 0, -10},      {20, 0.02, -10},
                       {-250, -250, -50}, {-240, -250, -50}, {-250, -240, -50}};
  sliver.triangles = {{0, 1, 2}};
  World world;
  world.add_solid("sliver", sliver);
  sliver.triangles = {{3, 4, 5}};
  world.add_solid("far off", sliver);
  const RayScene scene(world);
  std::array<Eigen::Vector3f, kPacketRays> directions;
  for (std::size_t k = 0; k < kPacketRays; ++k) {  // 20 cm to 5 cm short of the sliver's tip, in its plane
    const double x = -0.2 + 0.01 * static_cast<double>(k), y = x * 0.02 / 20 / 2;
    directions[k] = Eigen::Vector3d(x - 3, y, -10).normalized().cast<float>();
  }
  HitPacket hits;
  Blocked blocked;
  scene.cast({3, 0, 0}, packet_of(directions, 0), hits);
  scene.occluded({3, 0, 0}, packet_of(directions, 0), blocked);
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    EXPECT_EQ(hits.label[k], kNothing) << k;
    EXPECT_EQ(blocked[k], 0) << k;
  }
  for (std::size_t k = 0; k < kPacketRays; ++k) {  // on the sliver
    directions[k] =
        Eigen::Vector3d(static_cast<double>(k), 0.5e-3 * (3 + static_cast<double>(k)), -10).normalized().cast<float>();
  }
  scene.cast({3, 0, 0}, packet_of(directions, 0), hits);
  scene.occluded({3, 0, 0}, packet_of(directions, 0), blocked);
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    EXPECT_EQ(hits.label[k], kTerrain + 1) << k;
    EXPECT_EQ(blocked[k], -1) << k;
  }
}

TEST(RayScene, OnlyPointsBelowTheTerrainAreUnderGround) {
  const RayScene scene(slope_world({0, 0}));
  EXPECT_TRUE(scene.under_ground({40, 50, -10.1}));
  EXPECT_FALSE(scene.under_ground({40, 50, -9.9}));
  EXPECT_FALSE(scene.under_ground({-1, 50, -100}));
  EXPECT_FALSE(RayScene(World{}).under_ground({0, 0, -1}));
}

}  // namespace
}  // namespace uwsim
