// The laws behind the values in rays/tolerances.h: the surfaces passed to Embree lie outside the true surfaces by at
// least the error of float.
#include "uwsim/rays/tolerances.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "uwsim/core/random.h"
#include "uwsim/rays/raised_terrain.h"
#include "uwsim/rays/triangle_distance.h"
#include "uwsim/rays/widened_triangle.h"

namespace uwsim {
namespace {

Eigen::Vector3d random_vector(const RandomStream& random, std::uint64_t tick, std::uint32_t index) {
  return {random.normal(tick, index), random.normal(tick, index + 1), random.normal(tick, index + 2)};
}

TEST(Tolerances, AWidenedTriangleCoversADiscAroundEachPointOfTheTriangle) {
  const RandomStream random(1, "triangles");
  for (std::uint64_t k = 0; k < 3000; ++k) {
    const double widening_m = 0.01, thin = k % 2 == 0 ? 1 : std::pow(10.0, -4 * random.uniform(k, 20));
    const Eigen::Vector3d a = random_vector(random, k, 0), along = random_vector(random, k, 3);
    const Eigen::Vector3d across = along.cross(random_vector(random, k, 6)).normalized();
    const Corners t{a, a + along, a + 1.5 * random.uniform(k, 21) * along + thin * across};
    const Corners wide = widened(t, widening_m);
    for (std::uint32_t n = 0; n < 12; ++n) {
      const std::size_t edge = n % 3;
      const double at = n < 6 ? 0 : random.uniform(k, 22 + 2 * n), turn = 6.3 * random.uniform(k, 23 + 2 * n);
      const Eigen::Vector3d on_edge = t[edge] + at * (t[(edge + 1) % 3] - t[edge]);
      const Eigen::Vector3d off = std::cos(turn) * along.normalized() + std::sin(turn) * across;
      const Eigen::Vector3d point = on_edge + 0.999 * widening_m * off;
      EXPECT_LT((closest_on_triangle(point, wide) - point).norm(), 1e-9) << "triangle " << k << ", edge " << edge;
    }
  }
}

TEST(Tolerances, ThePartOfAWidenedTriangleWithinItsMarginIsOnTheTriangle) {
  const RandomStream random(4, "margins");
  int with_inside = 0;
  for (std::uint64_t k = 0; k < 3000; ++k) {
    const double thin = k % 2 == 0 ? 1 : std::pow(10.0, -2 * random.uniform(k, 20));
    const Eigen::Vector3d a = random_vector(random, k, 0), along = random_vector(random, k, 3);
    const Eigen::Vector3d across = along.cross(random_vector(random, k, 6)).normalized();
    const Corners t{a, a + along, a + 1.5 * random.uniform(k, 21) * along + thin * across};
    const Corners wide = widened(t, 0.01);
    const double margin = double{margin_within(wide, t)};
    if (!(3 * margin < 1)) continue;
    ++with_inside;
    for (std::size_t n = 0; n < 3; ++n) {  // the corners of that part
      const Eigen::Vector3d point = (1 - 2 * margin) * wide[n] + margin * (wide[(n + 1) % 3] + wide[(n + 2) % 3]);
      EXPECT_LT((closest_on_triangle(point, t) - point).norm(), 1e-9) << "triangle " << k;
    }
  }
  EXPECT_GT(with_inside, 2000);
}

TEST(Tolerances, RaisedTerrainIsOffEveryTriangleByTheRaiseAndBelowTheClearance) {
  const std::size_t n = 21;
  const RandomStream random(2, "heights");
  std::vector<float> heights(n * n);
  for (std::size_t k = 0; k < heights.size(); ++k) heights[k] = static_cast<float>(5 * random.normal(k));
  World world;
  world.set_terrain(Heightfield(heights, n, n, 0.5, {3, 4}));
  const TileContents block{.first_column = 2, .first_row = 3, .columns = 15, .rows = 12, .solids = {}, .meshes = {}};
  const double steep = steepest(world, block);
  const Tolerances tolerances = tolerances_of(100, steep, false);
  const auto vertex = [&](std::uint32_t i, std::uint32_t j) { return world.terrain()->vertex((3 + j) * n + 2 + i); };
  for (std::uint32_t j = 0; j < block.rows; ++j) {
    for (std::uint32_t i = 0; i < block.columns; ++i) {
      const Eigen::Vector3d lower = (vertex(i + 1, j) - vertex(i, j)).cross(vertex(i, j + 1) - vertex(i, j));
      const Eigen::Vector3d upper =
          (vertex(i, j + 1) - vertex(i + 1, j + 1)).cross(vertex(i + 1, j) - vertex(i + 1, j + 1));
      const auto raise = [&](std::uint32_t di, std::uint32_t dj) {
        return Eigen::Vector3d(tolerances.raise_m * raise_per_metre(world, block, i + di, j + dj));
      };
      for (const Eigen::Vector3d& shift : {raise(0, 0), raise(1, 0), raise(0, 1)}) {
        EXPECT_GE(lower.normalized().dot(shift), 0.999 * tolerances.raise_m);
      }
      for (const Eigen::Vector3d& shift : {raise(1, 1), raise(1, 0), raise(0, 1)}) {
        EXPECT_GE(upper.normalized().dot(shift), 0.999 * tolerances.raise_m);
        EXPECT_LE(shift.z(), 0.75 * tolerances.clearance_m);
      }
    }
  }
}

TEST(Tolerances, TheyGrowWithTheTileAndStayAboveFloatRounding) {
  const Tolerances tile = tolerances_of(std::numbers::sqrt2 * 1000, 1, true);
  const float coordinate_m = 500 * std::numbers::sqrt2_v<float>;  // a far corner, relative to the middle
  EXPECT_GE(tile.rounding_m, 8 * (std::nextafter(coordinate_m, 1e9f) - coordinate_m));
  EXPECT_GE(tile.widening_m, tile.rounding_m / 16 / kGrazingSine) << "one rounding, along a surface met at 0.1 degree";
  EXPECT_GE(tile.setback_m, tile.rounding_m / 16 / kGrazingSine);
  EXPECT_DOUBLE_EQ(tolerances_of(std::numbers::sqrt2 * 2000, 1, true).widening_m, 2 * tile.widening_m);
  EXPECT_EQ(tolerances_of(1e-6, 1, false).rounding_m, kLeastFloatError_m);
}

/// Two triangles separated by a gap along any direction, with all combinations of nearest features facing each other.
TEST(Tolerances, TrianglesAreAsFarApartAsTheGapBetweenThem) {
  const RandomStream random(3, "gaps");
  for (std::uint64_t k = 0; k < 2000; ++k) {
    const Eigen::Vector3d across = random_vector(random, k, 0).normalized();
    const Eigen::Vector3d u = across.unitOrthogonal(), v = across.cross(u);
    const double gap_m = 0.01 + random.uniform(k, 3);
    // Each triangle on its side of the gap: a corner, an edge or a face on the rim of the gap, over the point u, v = 0.
    const auto beside = [&](std::uint32_t draw, double side) {
      const double kind = random.uniform(k, draw);
      const auto level = [&](std::uint32_t n) { return side * (0.1 + random.uniform(k, draw + n)); };
      const double turn = 6.3 * random.uniform(k, draw + 7);
      const Eigen::Vector3d one = std::cos(turn) * u + std::sin(turn) * v, two = across.cross(one);
      const Eigen::Vector3d base = 0.5 * (gap_m * side) * across;
      if (kind < 0.33) return Corners{base, base + one + level(1) * across, base + two + level(2) * across};
      if (kind < 0.66) return Corners{base - one, base + one, base + two + level(1) * across};
      return Corners{base - one - two, base + 2 * one, base + 2 * two - one};
    };
    const Corners a = beside(4, 1), b = beside(20, -1);
    EXPECT_TRUE(closer_than(a, b, gap_m * (1 + 1e-9)) && closer_than(b, a, gap_m * (1 + 1e-9))) << k;
    EXPECT_FALSE(closer_than(a, b, gap_m * (1 - 1e-9)) || closer_than(b, a, gap_m * (1 - 1e-9))) << k;
    const Eigen::Vector3d middle = (a[0] + a[1] + a[2]) / 3, normal = (a[1] - a[0]).cross(a[2] - a[0]);
    const Corners through{middle - normal, middle + normal, middle + 2 * normal + across};
    EXPECT_TRUE(closer_than(a, through, 1e-6)) << "one pierces the other";
  }
}

}  // namespace
}  // namespace uwsim
