#include "uwsim/world/round_shape.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "meshes.h"
#include "uwsim/core/check.h"
#include "uwsim/core/random.h"
#include "uwsim/rays/ray_kernels.h"
#include "uwsim/rays/ray_lanes.h"
#include "uwsim/rays/ray_scene.h"

namespace uwsim {
namespace {

Eigen::Vector3d some_vector(const RandomStream& random, std::uint64_t tick, std::uint32_t index) {
  return {random.normal(tick, index), random.normal(tick, index + 1), random.normal(tick, index + 2)};
}

Pose some_pose(const RandomStream& random, std::uint64_t tick, double away_m) {
  const Eigen::Vector3d axis = some_vector(random, tick, 20).normalized();
  return {away_m * some_vector(random, tick, 23),
          Eigen::Quaterniond(Eigen::AngleAxisd(6.3 * random.uniform(tick, 26), axis))};
}

/// The first hit of a ray on a cylinder about the z axis that extends from -half to half.
double closed_form_m(double radius, double half, const Eigen::Vector3d& o, const Eigen::Vector3d& d) {
  double first = std::numeric_limits<double>::infinity();
  const double a = d.x() * d.x() + d.y() * d.y(), b = o.x() * d.x() + o.y() * d.y();
  const double c = o.x() * o.x() + o.y() * o.y() - radius * radius, root = b * b - a * c;
  for (const double sign : {-1.0, 1.0}) {
    const double wall = (-b + sign * std::sqrt(root)) / a;
    if (root >= 0 && wall >= 0 && std::abs(o.z() + wall * d.z()) <= half) first = std::min(first, wall);
    const double cap = (sign * half - o.z()) / d.z();
    const Eigen::Vector3d p = o + cap * d;
    if (cap >= 0 && std::hypot(p.x(), p.y()) <= radius) first = std::min(first, cap);
  }
  return first;
}

TEST(RoundShape, ARayMeetsASphereAtTheRootOfTheQuadratic) {
  const RandomStream random(1, "sphere");
  for (std::uint64_t k = 0; k < 2000; ++k) {
    const double radius = std::exp(2 * random.normal(k, 0));
    const Eigen::Vector3d o = 3 * radius * some_vector(random, k, 1);
    const Eigen::Vector3d d = (radius * some_vector(random, k, 4) - o).normalized();
    const double b = o.dot(d), root = b * b - o.squaredNorm() + radius * radius;
    const auto hit = first_hit(sphere({7, 8, 9}, radius), o + Eigen::Vector3d(7, 8, 9), d);
    const double near = -b - std::sqrt(root), far = -b + std::sqrt(root);
    ASSERT_EQ(hit.has_value(), root >= 0 && far >= 0) << k;
    if (!hit || root < 1e-6 * radius * radius) continue;
    EXPECT_NEAR(hit->distance_m, near >= 0 ? near : far, 1e-9 * radius) << k;
    EXPECT_NEAR((radius * hit->normal_world - (o + hit->distance_m * d)).norm(), 0, 1e-9 * radius) << k;
  }
}

TEST(RoundShape, ARayMeetsACylinderAtTheClosedFormDistanceWhateverItsAttitude) {
  const RandomStream random(2, "cylinder");
  int hits = 0;
  for (std::uint64_t k = 0; k < 5000; ++k) {
    const double radius = 0.1 + random.uniform(k, 0), half = 0.1 + 3 * random.uniform(k, 1);
    const Eigen::Vector3d o = 4 * some_vector(random, k, 2), aim = some_vector(random, k, 5);
    const Eigen::Vector3d d = (aim - o).normalized();
    const Pose world_from_own = some_pose(random, k, k % 2 == 0 ? 10 : 10'000);
    const RoundShape shape = cylinder(world_from_own.point({0, 0, -half}), world_from_own.point({0, 0, half}), radius);
    const auto hit = first_hit(shape, world_from_own.point(o), world_from_own.direction(d));
    const double expected = closed_form_m(radius, half, o, d);
    if (std::isinf(expected)) continue;
    ++hits;
    ASSERT_TRUE(hit.has_value()) << k;
    EXPECT_NEAR(hit->distance_m, expected, 1e-8) << k;
    EXPECT_NEAR(hit->normal_world.norm(), 1, 1e-12);
  }
  EXPECT_GT(hits, 1000);
}

TEST(RoundShape, HitsOnAPipeLieOneRadiusFromItsAxisAndNoRaySlipsThroughItsSeams) {
  const std::vector<Eigen::Vector3d> line = {{0, 0, 0}, {4, 0, 1}, {6, 3, 1}, {6, 8, -1}};
  const auto pieces = pipe(line, 0.3);
  const RandomStream random(3, "pipe");
  const auto to_axis = [&](const Eigen::Vector3d& p) {
    double least = 1e9;
    for (std::size_t k = 0; k + 1 < line.size(); ++k) {  // of infinite axes, because mitred ends extend beyond
      const Eigen::Vector3d axis = (line[k + 1] - line[k]).normalized();
      least = std::min(least, std::abs((p - line[k] - axis.dot(p - line[k]) * axis).norm() - 0.3));
    }
    return least;
  };
  for (std::uint64_t k = 0; k < 5000; ++k) {
    const std::size_t piece = k % 3;
    const double along = k % 4 == 0 ? 1 : random.uniform(k, 0);  // every fourth ray aims at a seam
    const Eigen::Vector3d aim = line[piece] + along * (line[piece + 1] - line[piece]);
    const Eigen::Vector3d origin = aim + 5 * some_vector(random, k, 1).normalized();
    const Eigen::Vector3d direction = (aim - origin).normalized();
    const Eigen::Vector3d along_last = (line[3] - line[2]).normalized(), from_bend = origin - line[2];
    if ((from_bend - along_last.dot(from_bend) * along_last).norm() < 0.4) continue;  // it might start inside the pipe
    double nearest = 1e9;
    for (const RoundShape& shape : pieces) {
      if (const auto hit = first_hit(shape, origin, direction)) nearest = std::min(nearest, hit->distance_m);
    }
    ASSERT_LT(nearest, 5 + 1e-9) << "through the wall at " << k;
    const Eigen::Vector3d point = origin + nearest * direction;
    const bool on_cap = (point - line.front()).norm() < 0.31 || (point - line.back()).norm() < 0.31;
    if (!on_cap) {
      EXPECT_NEAR(to_axis(point), 0, 1e-9) << k;
    }
  }
}

TEST(RoundShape, TheSceneMeetsRoundShapesExactlyTenKilometresOut) {
  const Eigen::Vector3d far_away(10'000.3, -9'999.9, -30);
  World world;
  world.add_solid("ball", testing::box(1, 1, 1), {sphere(far_away, 2)});
  const RayScene scene(world);
  const RandomStream random(4, "far");
  for (std::uint64_t k = 0; k < 2000; ++k) {
    const Eigen::Vector3d origin = far_away + 60 * random.uniform(k, 0) * some_vector(random, k, 1);
    const Eigen::Vector3d direction = (far_away + 1.1 * some_vector(random, k, 4) - origin).normalized();
    const Eigen::Vector3d o = origin - far_away;
    const double b = o.dot(direction), root = b * b - o.squaredNorm() + 4;
    const RayHit hit = scene.cast({origin, direction}, 500);
    const double near = -b - std::sqrt(root), expected = near >= 0 ? near : -b + std::sqrt(root);
    if (root > 0 && std::sqrt(root) / 2 < 1.75e-3) continue;  // within 0.1 degree of tangency
    ASSERT_EQ(hit.label, root > 0 && expected >= 0 && expected <= 500 ? kTerrain + 1 : kNothing) << k;
    if (hit.label != kNothing) {
      EXPECT_NEAR(hit.distance_m, expected, 1e-9) << k;
    }
  }
}

TEST(RoundShape, FloatPacketsMeetRoundShapes) {
  World world;
  world.add_solid("post", testing::box(1, 1, 1), {cylinder({5, 0, -3}, {5, 0, 3}, 1)});
  const RayScene scene(world);
  RayPacket rays;
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    const double turn = 0.02 * static_cast<double>(k);
    rays.origin_x[k] = rays.origin_y[k] = rays.origin_z[k] = 0;
    rays.direction_x[k] = static_cast<float>(std::cos(turn));
    rays.direction_y[k] = static_cast<float>(std::sin(turn));
    rays.direction_z[k] = rays.near_m[k] = 0;
    rays.far_m[k] = 50;
    rays.active[k] = -1;
  }
  HitPacket hits;
  Blocked blocked;
  scene.cast({0, 0, 0}, rays, hits);
  scene.occluded({0, 0, 0}, rays, blocked);
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    const double turn = 0.02 * static_cast<double>(k), root = 1 - std::pow(5 * std::sin(turn), 2);
    EXPECT_EQ(hits.label[k], root > 0 ? kTerrain + 1u : 0u) << k;
    EXPECT_EQ(blocked[k], root > 0 ? -1 : 0) << k;
    if (root > 0) {
      EXPECT_NEAR(hits.distance_m[k], 5 * std::cos(turn) - std::sqrt(root), 1e-5) << k;
    }
  }
}

TEST(RoundShape, SixteenRaysMeetAWallWithTheBitsOfOneAtATime) {
  const RandomStream random(7, "walls");
  int met_count = 0, along_count = 0;
  for (const RayKernels* kernels : {&baseline_ray_kernels(), &ray_kernels()}) {
    for (std::uint64_t turn = 0; turn < 400; ++turn) {
      const double radius = std::exp(random.normal(turn, 90));
      std::vector<Eigen::Vector3d> line{100 * some_vector(random, turn, 91)};
      for (std::uint32_t k = 0; k < 3; ++k) {
        line.push_back(line.back() +
                       5 * radius * (Eigen::Vector3d(1, 0, 0) + 0.3 * some_vector(random, turn, 100 + 3 * k)));
      }
      const RoundShape piece = pipe(line, radius)[1];
      ASSERT_TRUE(piece.is_open());
      ExactRays rays;
      ExactHits hits;
      ExactRays::Lanes near_m;
      std::array<std::int32_t, kPacketRays> met;
      for (std::uint32_t k = 0; k < kPacketRays; ++k) {
        const Eigen::Vector3d from = line[1] + 4 * radius * some_vector(random, turn, 200 + 8 * k);
        const Eigen::Vector3d to = line[1] + radius * some_vector(random, turn, 204 + 8 * k);
        set_ray(rays, k, from, k == 0 ? piece.axis : (to - from).normalized(), 20 * radius, true);
        near_m[k] = k % 4 == 3 ? 3 * radius : 0;
      }
      const auto& [one, other] = piece.ends;
      kernels->meet_wall(
          lanes_of(rays), near_m.data(),
          {piece.axis.data(),
           {one.point_world_m.data(), other.point_world_m.data()},
           {one.outward.data(), other.outward.data()},
           radius,
           kSeam_m,
           kAlongAxis},
          {hits.distance_m.data(), hits.normal_x.data(), hits.normal_y.data(), hits.normal_z.data(), met.data()});
      for (std::size_t k = 0; k < kPacketRays; ++k) {
        const auto hit = first_hit(piece, origin_of(rays, k), direction_of(rays, k), near_m[k], rays.far_m[k]);
        along_count += met[k] == kAlong;
        if (met[k] == kAlong) continue;
        ASSERT_EQ(met[k] == kMeets, hit.has_value()) << turn << " " << k;
        if (!hit) continue;
        ++met_count;
        EXPECT_EQ(hits.distance_m[k], hit->distance_m) << turn << " " << k;
        EXPECT_EQ(normal_of(hits, k), hit->normal_world) << turn << " " << k;
      }
    }
  }
  EXPECT_GT(met_count, 1000);
  EXPECT_GT(along_count, 100);
}

TEST(RoundShape, InvalidShapesAreRefused) {
  EXPECT_THROW(sphere({0, 0, 0}, 0), InvalidValue);
  EXPECT_THROW(sphere({0, NAN, 0}, 1), InvalidValue);
  EXPECT_THROW(cylinder({1, 2, 3}, {1, 2, 3}, 1), InvalidValue);
  EXPECT_THROW(cylinder({1, 2, 3}, {1, 2, 4}, -1), InvalidValue);
  EXPECT_THROW(pipe({{0, 0, 0}}, 1), InvalidValue);
  EXPECT_THROW(pipe({{0, 0, 0}, {1, 0, 0}, {0, 0, 0}}, 1), InvalidValue) << "turns back on itself";
}

}  // namespace
}  // namespace uwsim
