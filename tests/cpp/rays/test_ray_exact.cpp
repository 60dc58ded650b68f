// Compares the ray scene with a brute-force cast in double over every triangle and shape of the world.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <numbers>

#include "meshes.h"
#include "rays/grazing.h"
#include "uwsim/core/random.h"
#include "uwsim/rays/ray_scene.h"

namespace uwsim {
namespace {

constexpr double kEdge = 1e-10;  // barycentric; rounding may make a ray aimed at an edge miss it on either side

struct Met {
  double distance_m = kInfinity;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  Label label = kNothing;
};

/// Tests a ray against every triangle and shape.
class BruteForce {
 public:
  explicit BruteForce(const World& world) : world_(world) {
    if (const auto& terrain = world.terrain()) {
      for (std::size_t k = 0; k < terrain->triangle_count(); ++k) {
        const Triangle t = terrain->triangle(k);
        add(terrain->vertex(t[0]), terrain->vertex(t[1]), terrain->vertex(t[2]), kTerrain);
      }
    }
    for (std::size_t s = 0; s < world.solids().size(); ++s) {
      const Solid& solid = *world.solids()[s];
      if (!solid.shapes.empty()) continue;
      const auto& v = solid.mesh_world.vertices_m;
      for (const Triangle& t : solid.mesh_world.triangles)
        add(v[t[0]], v[t[1]], v[t[2]], static_cast<Label>(kTerrain + 1 + s));
    }
  }

  Met cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double far_m) const {
    Met first;
    for (const Facet& f : facets_) {
      const Eigen::Vector3d p = direction.cross(f.ac);
      const double determinant = f.ab.dot(p);
      if (determinant == 0) continue;
      const Eigen::Vector3d from = origin - f.a, q = from.cross(f.ab);
      const double u = from.dot(p) / determinant, v = direction.dot(q) / determinant,
                   distance = f.ac.dot(q) / determinant;
      if (u < -kEdge || v < -kEdge || u + v > 1 + kEdge || distance < 0 || distance > far_m ||
          distance >= first.distance_m)
        continue;
      first = {distance, f.ab.cross(f.ac).normalized(), f.label};
    }
    for (std::size_t s = 0; s < world_.solids().size(); ++s) {
      for (const RoundShape& shape : world_.solids()[s]->shapes) {
        const auto hit = first_hit(shape, origin, direction, 0, far_m);
        if (hit && hit->distance_m < first.distance_m)
          first = {hit->distance_m, hit->normal_world, static_cast<Label>(kTerrain + 1 + s)};
      }
    }
    return first;
  }

  /// A corner of a triangle, a point on one of its edges, or a point inside it.
  Eigen::Vector3d target(const RandomStream& random, std::uint64_t k) const {
    const auto pick = static_cast<std::size_t>(random.uniform(k, 0) * static_cast<double>(facets_.size()));
    const Facet& f = facets_[pick];
    const double kind = random.uniform(k, 1), along = random.uniform(k, 2), across = random.uniform(k, 3);
    if (kind < 0.3) return f.a;
    if (kind < 0.6) return f.a + along * (along < 0.5 ? f.ab : f.ac);
    return f.a + along * (1 - across) * f.ab + (1 - along) * (1 - across) * f.ac;
  }

 private:
  struct Facet {
    Eigen::Vector3d a, ab, ac;
    Label label;
  };
  void add(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c, Label label) {
    facets_.push_back({a, b - a, c - a, label});
  }

  const World& world_;
  std::vector<Facet> facets_;
};

TriangleMesh placed(TriangleMesh mesh, const Eigen::Vector3d& at, double turn) {
  const Eigen::AngleAxisd rotation(turn, Eigen::Vector3d(1, 2, 3).normalized());
  for (Eigen::Vector3d& v : mesh.vertices_m) v = at + rotation * v;
  return mesh;
}

/// A spiky bed with a box and a faceted ball half sunk into it, and a round pipe, post and ball.
World spiky_world(std::size_t cells, double spacing_m, const Eigen::Vector2d& origin_m) {
  const RandomStream random(7, "spiky bed");
  std::vector<float> heights((cells + 1) * (cells + 1));
  for (std::size_t k = 0; k < heights.size(); ++k) heights[k] = static_cast<float>(-20 + 1.5 * random.normal(k));
  World world;
  world.set_terrain(Heightfield(heights, cells + 1, cells + 1, spacing_m, origin_m));
  const double size = static_cast<double>(cells) * spacing_m;
  const auto at = [&](double x, double y, double z) {
    return Eigen::Vector3d(origin_m.x() + x * size, origin_m.y() + y * size, z);
  };
  const double r = 0.04 * size;
  world.add_solid("box", placed(testing::box(4 * r, 2 * r, 3 * r), at(0.3, 0.3, -19), 0.8));
  world.add_solid("facets", placed(testing::sphere(2 * r, 10), at(0.7, 0.4, -20), 0.3));
  const TriangleMesh unused = placed(testing::box(r, r, r), at(0.5, 0.5, -20), 0);  // rays hit the shapes instead
  world.add_solid("pipe", unused, pipe({at(0.1, 0.7, -19), at(0.4, 0.75, -19.5), at(0.8, 0.6, -18)}, 0.5 * r));
  world.add_solid("ball", unused, {sphere(at(0.33, 0.35, -18), 1.5 * r)});
  world.add_solid("post", unused, {cylinder(at(0.6, 0.8, -25), at(0.62, 0.8, -10), 0.3 * r)});
  return world;
}

int rays_to_cast() {
  const char* wanted = std::getenv("UWSIM_RAYS");  // for longer manual runs
  return wanted != nullptr ? std::atoi(wanted) : 3000;
}

/// Casts rays past corners and edges of the world, from up to `span_m` away, and expects the same hits as from brute
/// force.
void expect_exact(const World& world, double span_m, std::uint64_t seed) {
  const RayScene scene(world);
  const BruteForce brute(world);
  const RandomStream random(seed, "rays");
  int compared = 0, wrong = 0, hit_count = 0;
  double worst_m = 0;
  for (int k = 0; k < rays_to_cast(); ++k) {
    const auto tick = static_cast<std::uint64_t>(k);
    // Miss distance from the target: zero, or 10 nm to 1 cm.
    const double beside = random.uniform(tick, 4) < 0.3 ? 0 : std::pow(10.0, -8 + 6 * random.uniform(tick, 5));
    const Eigen::Vector3d aim =
        brute.target(random, tick) +
        beside * Eigen::Vector3d(random.normal(tick, 6), random.normal(tick, 7), random.normal(tick, 8));
    Eigen::Vector3d from(random.normal(tick, 9), random.normal(tick, 10), std::abs(random.normal(tick, 11)) + 0.1);
    const Eigen::Vector3d origin =
        aim + span_m * random.uniform(tick, 12) * from.normalized() + Eigen::Vector3d(0, 0, 0.5);
    const Eigen::Vector3d direction = (aim - origin).normalized();
    const Met expected = brute.cast(origin, direction, 3 * span_m);
    const RayHit got = scene.cast({origin, direction}, 3 * span_m);
    if (expected.label != kNothing && std::abs(expected.normal.dot(direction)) < kGrazing) continue;
    if (got.label != kNothing && std::abs(got.normal_world.cast<double>().dot(direction)) < kGrazing) continue;
    ++compared;
    hit_count += expected.label != kNothing;
    const double error = expected.distance_m == got.distance_m ? 0 : std::abs(expected.distance_m - got.distance_m);
    const bool fine = error == 0 || error <= std::max(1e-5, 1e-7 * std::min(expected.distance_m, got.distance_m));
    worst_m = fine ? std::max(worst_m, error) : worst_m;
    if (!fine && ++wrong <= 5) {
      ADD_FAILURE() << "ray " << k << ": expected " << expected.distance_m << " m on " << expected.label << ", got "
                    << got.distance_m << " m on " << got.label << ", sines " << std::abs(expected.normal.dot(direction))
                    << " and " << std::abs(got.normal_world.cast<double>().dot(direction)) << ", beside " << beside;
    }
  }
  EXPECT_EQ(wrong, 0) << "of " << compared;
  EXPECT_GT(compared, rays_to_cast() * 9 / 10);
  EXPECT_GT(hit_count, compared / 2);
  EXPECT_LT(worst_m, 1e-9) << "hits are solved in double";
}

/// Whether the two results agree to 1e-5 m or 1e-7 of the range, or one of them grazes.
bool agrees(const Met& expected, const RayHit& got, const Eigen::Vector3d& direction, double least_sine) {
  if (expected.label != kNothing && std::abs(expected.normal.dot(direction)) < least_sine) return true;
  if (got.label != kNothing && std::abs(got.normal_world.cast<double>().dot(direction)) < least_sine) return true;
  if (expected.distance_m == got.distance_m) return true;
  const double nearer_m = std::min(expected.distance_m, got.distance_m);
  return std::abs(expected.distance_m - got.distance_m) <= std::max(1e-5, 1e-7 * nearer_m);
}

Eigen::Vector3d random_direction(const RandomStream& random, std::uint64_t tick, std::uint32_t draw) {
  const Eigen::Vector3d direction(random.normal(tick, draw), random.normal(tick, draw + 1),
                                  random.normal(tick, draw + 2));
  return direction.normalized();
}

/// The number of wrong results for rays in random directions that start 1e-7 m to 1 mm from a surface, on either side.
int wrong_near_surfaces(const World& world, std::uint64_t seed) {
  const RayScene scene(world);
  const BruteForce brute(world);
  const RandomStream random(seed, "starts");
  int wrong = 0;
  for (std::uint64_t k = 0; k < static_cast<std::uint64_t>(rays_to_cast()); ++k) {
    const Eigen::Vector3d off = std::pow(10.0, -7 + 4 * random.uniform(k, 4)) * random_direction(random, k, 5);
    const Eigen::Vector3d origin = brute.target(random, k) + off, direction = random_direction(random, k, 8);
    const Met expected = brute.cast(origin, direction, 5000);
    const RayHit got = scene.cast({origin, direction}, 5000);
    wrong += !agrees(expected, got, direction, kGrazing);
  }
  return wrong;
}

/// The number of wrong results for rays that pass the edges of free-standing triangles by up to `beside_m`.
int wrong_past_edges(const World& world, double beside_m, double span_m, std::uint64_t seed) {
  const RayScene scene(world);
  const BruteForce brute(world);
  const RandomStream random(seed, "edges");
  int wrong = 0;
  for (std::uint64_t k = 0; k < static_cast<std::uint64_t>(rays_to_cast()); ++k) {
    const Eigen::Vector3d aim =
        brute.target(random, k) + beside_m * random.uniform(k, 4) * random_direction(random, k, 5);
    const Eigen::Vector3d direction = random_direction(random, k, 8),
                          origin = aim - span_m * random.uniform(k, 11) * direction;
    const Met expected = brute.cast(origin, direction, 2 * span_m);
    const RayHit got = scene.cast({origin, direction}, 2 * span_m);
    wrong += !agrees(expected, got, direction, kGrazing);
  }
  return wrong;
}

/// Free-standing triangles scattered over `spread_m`: slivers, or triangles as wide as they are long.
World strewn_triangles(int count, double length_m, double width_m, double spread_m) {
  const RandomStream random(11, "strewn");
  TriangleMesh mesh;
  for (std::uint64_t k = 0; k < static_cast<std::uint64_t>(count); ++k) {
    const Eigen::Vector3d at(spread_m * random.uniform(k, 0), spread_m * random.uniform(k, 1),
                             -50 * random.uniform(k, 2));
    const Eigen::Vector3d along = random_direction(random, k, 3),
                          across = along.cross(random_direction(random, k, 6)).normalized();
    const auto first = static_cast<std::uint32_t>(mesh.vertices_m.size());
    const double thin = width_m * std::pow(10.0, -2 * random.uniform(k, 9));
    mesh.vertices_m.insert(mesh.vertices_m.end(),
                           {at, at + length_m * along, at + length_m * random.uniform(k, 10) * along + thin * across});
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  World world;
  world.add_solid("strewn", mesh);
  return world;
}

TEST(RayExact, HitsAreExactOverASpikyBedWithSolidsSunkIntoIt) { expect_exact(spiky_world(40, 0.5, {-10, -10}), 30, 1); }

TEST(RayExact, HitsAreExactTenKilometresFromTheOrigin) {
  expect_exact(spiky_world(40, 0.5, {10'000.3, -10'000.7}), 30, 2);
}

TEST(RayExact, HitsAreExactInAWorldFourHundredMetresWide) { expect_exact(spiky_world(40, 10, {-3, 5}), 150, 3); }

TEST(RayExact, HitsAreExactThroughTheTilesOfAWorldSeveralKilometresWide) {
  expect_exact(spiky_world(40, 90, {7000, 1000}), 2000, 4);
}

TEST(RayExact, WhereABallMeetsTheBedTheNearerOfTheTwoIsHitHoweverCloseTheyAre) {
  World world;
  world.set_terrain(Heightfield(std::vector<float>(41 * 41, -20.0f), 41, 41, 10.0, {-190, -210}));
  world.add_solid("ball", testing::box(1, 1, 1), {sphere({3, 4, -20}, 1)});
  const RayScene scene(world);
  const RandomStream random(5, "crossing");
  for (std::uint64_t k = 0; k < 20'000; ++k) {
    const double turn = 2 * std::numbers::pi * random.uniform(k, 0),
                 off = std::pow(10.0, -7 + 4 * random.uniform(k, 1));
    const double side = random.uniform(k, 2) < 0.5 ? -off : off;
    const Eigen::Vector3d aim(3 + (1 + side) * std::cos(turn), 4 + (1 + side) * std::sin(turn), -20);
    // Starts outside the ball, at a steep or shallow angle.
    const double dip = 0.02 + 1.5 * random.uniform(k, 3), bearing = turn + random.uniform(k, 4) - 0.5;
    const Eigen::Vector3d direction(-std::cos(dip) * std::cos(bearing), -std::cos(dip) * std::sin(bearing),
                                    -std::sin(dip));
    const Eigen::Vector3d origin = aim - 40 * direction, o = origin - Eigen::Vector3d(3, 4, -20);
    const double b = o.dot(direction), root = b * b - o.squaredNorm() + 1;
    const double to_bed = (-20 - origin.z()) / direction.z();
    const double to_ball = root >= 0 ? -b - std::sqrt(root) : kInfinity;
    if (root > -1e-9 && root < 4e-6) continue;  // grazes the ball
    const RayHit hit = scene.cast({origin, direction}, 100);
    ASSERT_NEAR(hit.distance_m, std::min(to_bed, to_ball), 1e-9) << k;
  }
}

TEST(RayExact, RaysThatStartCloseToASurfaceAreExact) {
  EXPECT_EQ(wrong_near_surfaces(spiky_world(40, 0.5, {-10, -10}), 1), 0);
  EXPECT_EQ(wrong_near_surfaces(spiky_world(40, 0.5, {10'000.3, -10'000.7}), 2), 0);
  EXPECT_EQ(wrong_near_surfaces(spiky_world(40, 10, {-3, 5}), 3), 0);
  EXPECT_EQ(wrong_near_surfaces(spiky_world(40, 90, {7000, 1000}), 4), 0);
}

TEST(RayExact, RaysPastTheEdgesOfFreeSliversAreExact) {
  EXPECT_EQ(wrong_past_edges(strewn_triangles(100, 2, 1e-2, 20), 1e-5, 20, 5), 0);
  EXPECT_EQ(wrong_past_edges(strewn_triangles(100, 20, 1e-2, 900), 2e-5, 100, 6), 0);
}

TEST(RayExact, RaysPastTheEdgesOfFreeTrianglesAreExactWhetherSmallOrKilometresLong) {
  EXPECT_EQ(wrong_past_edges(strewn_triangles(100, 2, 2, 20), 1e-5, 20, 7), 0);
  EXPECT_EQ(wrong_past_edges(strewn_triangles(30, 4000, 4000, 3000), 1e-4, 2000, 8), 0);
  EXPECT_EQ(wrong_past_edges(strewn_triangles(30, 4000, 4000, 3000), 100, 2000, 9), 0);
}

/// The number of wrong results for rays that hit single triangles of this size at 0.1 to 0.5 degree, passing their
/// edges on either side.
int wrong_at_grazing_edges(double length_m) {
  const RandomStream random(17, "grazing");
  int wrong = 0;
  std::uint64_t tick = 0;
  for (int triangle = 0; triangle < rays_to_cast() / 100; ++triangle) {
    TriangleMesh mesh;
    for (int corner = 0; corner < 3; ++corner)
      mesh.vertices_m.push_back(length_m * random_direction(random, ++tick, 0));
    mesh.triangles.push_back({0, 1, 2});
    const auto& v = mesh.vertices_m;
    const Eigen::Vector3d normal = (v[1] - v[0]).cross(v[2] - v[0]).normalized();
    World world;
    world.add_solid("single", mesh);
    const RayScene scene(world);
    const BruteForce brute(world);
    for (int k = 0; k < 100; ++k, ++tick) {
      const auto edge = static_cast<std::size_t>(k % 3);
      const Eigen::Vector3d along = v[(edge + 1) % 3] - v[edge], across = normal.cross(along).normalized();
      const double off = std::pow(10.0, -8 + 7 * random.uniform(tick, 0)) * (k % 2 == 0 ? 1 : -1);
      const Eigen::Vector3d aim = v[edge] + random.uniform(tick, 1) * along + off * across;
      const double turn = 2 * std::numbers::pi * random.uniform(tick, 2);
      const double sine = (kGrazing + 7e-3 * random.uniform(tick, 3)) * (k % 4 < 2 ? 1 : -1);
      const Eigen::Vector3d level = std::cos(turn) * along.normalized() + std::sin(turn) * across;
      const Eigen::Vector3d direction = (level + sine * normal).normalized();
      const Eigen::Vector3d origin = aim - length_m * random.uniform(tick, 4) * direction;
      wrong += !agrees(brute.cast(origin, direction, 2 * length_m), scene.cast({origin, direction}, 2 * length_m),
                       direction, kGrazing);
    }
  }
  return wrong;
}

TEST(RayExact, RaysThatGrazeTheEdgesOfSingleTrianglesAreExact) {
  for (const double length_m : {3.0, 60.0, 800.0, 4000.0}) EXPECT_EQ(wrong_at_grazing_edges(length_m), 0) << length_m;
}

}  // namespace
}  // namespace uwsim
