#include "uwsim/rays/moving_bodies.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <numbers>

#include "meshes.h"
#include "rays/grazing.h"
#include "uwsim/core/check.h"
#include "uwsim/core/random.h"
#include "uwsim/rays/ray_lanes.h"
#include "uwsim/rays/ray_scene.h"

namespace uwsim {
namespace {

/// A wavy bed and a box on it.
World bed_with_box(const Eigen::Vector2d& middle) {
  std::vector<float> heights;
  for (int k = 0; k < 41 * 41; ++k) heights.push_back(static_cast<float>(-20 + std::sin(0.7 * k) + std::cos(0.3 * k)));
  World world;
  world.set_terrain(Heightfield(std::move(heights), 41, 41, 2.0, middle - Eigen::Vector2d(40, 40)));
  TriangleMesh box = testing::box(4, 4, 4);
  for (Eigen::Vector3d& v : box.vertices_m) v += Eigen::Vector3d(middle.x() + 10, middle.y(), -18);
  world.add_solid("box", box);
  return world;
}

Pose pose(const Eigen::Vector3d& position_m, double turn_rad = 0) {
  return {position_m, Eigen::Quaterniond(Eigen::AngleAxisd(turn_rad, Eigen::Vector3d(1, -2, 3).normalized()))};
}

TriangleMesh placed(TriangleMesh mesh, const Pose& at) {
  for (Eigen::Vector3d& v : mesh.vertices_m) v = at.point(v);
  return mesh;
}

Eigen::Vector3d unit_vector(const RandomStream& random, std::uint64_t k, std::uint32_t draw) {
  return Eigen::Vector3d(random.normal(k, draw), random.normal(k, draw + 1), random.normal(k, draw + 2)).normalized();
}

/// Two bodies above the bed, and the same bodies as fixed solids of a second world.
struct Twice {
  explicit Twice(const Eigen::Vector2d& middle)
      : world(bed_with_box(middle)), fixed_world(world), bodies(std::make_shared<MovingBodies>(Label{3})) {
    const Pose poses[] = {pose({middle.x(), middle.y(), -15}, 0.7), pose({middle.x() + 3, middle.y() + 2, -17}, 2)};
    const TriangleMesh meshes[] = {testing::sphere(1.5, 9), testing::box(2, 1, 0.5)};
    for (std::size_t k = 0; k < 2; ++k) {
      bodies->place(bodies->add(meshes[k]), poses[k]);
      fixed_world.add_solid(k == 0 ? "first" : "second", placed(meshes[k], poses[k]));
    }
  }
  RayScene moving() const { return RayScene(world).with(bodies); }

  World world, fixed_world;
  std::shared_ptr<MovingBodies> bodies;
};

TEST(MovingBodies, RaysMeetThemAsTheyMeetFixedSolidsAtTheSamePlace) {
  for (const double offset : {0.0, 20'000.0}) {
    const Twice twice({offset, -offset});
    const RayScene moving = twice.moving(), fixed(twice.fixed_world);
    const RandomStream random(5, "rays");
    int on_bodies = 0;
    for (std::uint64_t k = 0; k < 4000; ++k) {
      const Eigen::Vector3d aim(offset + 4 * random.normal(k, 0), -offset + 4 * random.normal(k, 1),
                                -16 + 2 * random.normal(k, 2));
      const Eigen::Vector3d direction = unit_vector(random, k, 3);
      const Ray ray{aim - 30 * random.uniform(k, 6) * direction, direction};
      const RayHit got = moving.cast(ray, 100), expected = fixed.cast(ray, 100);
      const bool grazes = std::abs(got.normal_world.cast<double>().dot(direction)) < kGrazing ||
                          std::abs(expected.normal_world.cast<double>().dot(direction)) < kGrazing;
      if (grazes && expected.label != kNothing) continue;
      ASSERT_EQ(got.label, expected.label) << k;
      if (expected.label == kNothing) continue;
      ASSERT_NEAR(got.distance_m, expected.distance_m, offset == 0 ? 1e-9 : 1e-8) << k;
      ASSERT_LT((got.normal_world - expected.normal_world).norm(), 1e-5f) << k;
      on_bodies += expected.label >= 3;
    }
    EXPECT_GT(on_bodies, 250);
  }
}

TEST(MovingBodies, AnEchoMovesWithItsBodyAndAHiddenBodyGivesNone) {
  const World world = bed_with_box({0, 0});
  const auto bodies = std::make_shared<MovingBodies>(Label{3});
  bodies->add(testing::sphere(1, 16));  // has a vertex on each axis
  bodies->add(testing::sphere(1, 16));
  const RayScene scene = RayScene(world).with(bodies), without_first = scene.with(bodies, 0);
  const Ray ahead{{0, 0, -10}, Eigen::Vector3d::UnitX()};
  for (const double x : {5.0, 17.25, 2000.0, 90'000.0}) {
    bodies->place(0, pose({x, 0, -10}));
    bodies->place(1, pose({x + 10, 0, -10}));
    EXPECT_NEAR(scene.cast(ahead, 1e6).distance_m, x - 1, 1e-9 + 1e-14 * x);
    EXPECT_EQ(scene.cast(ahead, 1e6).label, 3);
    EXPECT_NEAR(without_first.cast(ahead, 1e6).distance_m, x + 9, 1e-9 + 1e-14 * x);
    EXPECT_EQ(without_first.cast(ahead, 1e6).label, 4);
    EXPECT_EQ(scene.cast(ahead, x - 1.001).distance_m, kInfinity) << "beyond the range";
    EXPECT_EQ(RayScene(world).cast(ahead, 1e6).distance_m, kInfinity) << "copies share no bodies";
  }
  bodies->place(0, pose({0, 0, -10}));
  EXPECT_NEAR(scene.cast(ahead, 1e6).distance_m, 1, 1e-9) << "from within";
}

TEST(MovingBodies, FloatPacketsAndShadowsMeetWhatExactRaysMeet) {
  const Twice twice({0, 0});
  const RayScene scene = twice.moving();
  const RandomStream random(6, "packets");
  const Eigen::Vector3d anchor(-12, 3, -11);
  int on_bodies = 0, different = 0;
  for (std::uint64_t p = 0; p < 150; ++p) {
    RayPacket rays{};
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      const std::uint64_t tick = p * kPacketRays + k;
      const Eigen::Vector3d origin = 0.5 * unit_vector(random, tick, 0);
      const Eigen::Vector3d aim(4 * random.normal(tick, 3), 4 * random.normal(tick, 4),
                                -15 + 2 * random.normal(tick, 5));
      const Eigen::Vector3f direction = (aim - anchor - origin).normalized().cast<float>().normalized();
      rays.origin_x[k] = static_cast<float>(origin.x()), rays.origin_y[k] = static_cast<float>(origin.y());
      rays.origin_z[k] = static_cast<float>(origin.z());
      rays.direction_x[k] = direction.x(), rays.direction_y[k] = direction.y(), rays.direction_z[k] = direction.z();
      rays.far_m[k] = 60;
      rays.active[k] = k % 5 == 0 ? 0 : -1;
    }
    HitPacket hits;
    Blocked blocked;
    scene.cast(anchor, rays, hits);
    scene.occluded(anchor, rays, blocked);
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      if (rays.active[k] == 0) {
        EXPECT_EQ(blocked[k], 0);
        continue;
      }
      const Ray ray{anchor + origin_of(rays, k).cast<double>(), direction_of(rays, k).cast<double>().normalized()};
      const RayHit exact = scene.cast(ray, 60);
      if (exact.label != hits.label[k] || (exact.label != kNothing) != (blocked[k] != 0)) {
        ++different;  // at a silhouette
        continue;
      }
      if (exact.label == kNothing) continue;
      const double sine = std::abs(exact.normal_world.cast<double>().dot(ray.direction_world));
      EXPECT_NEAR(hits.distance_m[k], exact.distance_m, 2e-4 / std::max(sine, 0.02));
      const Eigen::Vector3f normal(hits.normal_x[k], hits.normal_y[k], hits.normal_z[k]);
      EXPECT_LT((normal.normalized() - exact.normal_world).norm(), 0.01f);
      on_bodies += exact.label >= 3;
    }
  }
  EXPECT_GT(on_bodies, 200);
  EXPECT_LE(different, 2);
}

TEST(MovingBodies, ResultsDoNotDependOnThreadsNorOnWhichRaysAreCastTogether) {
  const Twice twice({0, 0});
  const RayScene scene = twice.moving();
  const RandomStream random(7, "threads");
  std::vector<Ray> rays(20'000);
  for (std::uint64_t k = 0; k < rays.size(); ++k) {
    const Eigen::Vector3d direction = unit_vector(random, k, 0);
    rays[k] = {Eigen::Vector3d(0, 0, -16) - 12 * direction + 2 * unit_vector(random, k, 3), direction};
  }
  std::vector<RayHit> one(rays.size()), many(rays.size());
  scene.cast(rays, 100, one, 1);
  scene.cast(rays, 100, many, 4);
  for (std::size_t k = 0; k < rays.size(); ++k) {
    ASSERT_EQ(one[k].distance_m, many[k].distance_m);
    ASSERT_EQ(one[k].label, many[k].label);
    ASSERT_EQ(scene.cast(rays[k], 100).distance_m, one[k].distance_m);
  }
}

TEST(MovingBodies, TheyAreKnownByDistanceAndCone) {
  const auto bodies = std::make_shared<MovingBodies>(Label{2});
  bodies->place(bodies->add(testing::box(2, 2, 2)), pose({10, 0, -5}));
  const RayScene scene = RayScene(World{}).with(bodies);
  const Eigen::Vector3d point(4, 0, -5);
  double distance_m = 0;
  scene.distance({&point, 1}, {&distance_m, 1});
  EXPECT_NEAR(distance_m, 5, 1e-9);
  const auto cone = [&](const Eigen::Vector3d& axis, double half_angle_deg, double length_m) {
    return RayCone{point, axis, std::cos(half_angle_deg * std::numbers::pi / 180), length_m};
  };
  const Eigen::Vector3d ahead(1, 0, 0), aside(0, 1, 0);
  EXPECT_TRUE(scene.bodies_in(cone(ahead, 0, 5)));
  EXPECT_FALSE(scene.bodies_in(cone(ahead, 0, 4))) << "the sphere around the box begins at 4.27 m";
  EXPECT_TRUE(scene.bodies_in(cone(aside, 80, 100))) << "the sphere is 17 degrees wide, to each side of 90";
  EXPECT_FALSE(scene.bodies_in(cone(aside, 70, 100)));
  EXPECT_FALSE(scene.with(bodies, 0).bodies_in(cone(ahead, 0, 5)));
  EXPECT_FALSE(scene.with(nullptr).bodies_in(cone(ahead, 180, 1e6)));
  EXPECT_THROW(bodies->add(TriangleMesh{}), InvalidValue);
}

}  // namespace
}  // namespace uwsim
