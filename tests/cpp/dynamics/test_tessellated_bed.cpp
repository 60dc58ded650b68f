#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "dynamics/bodies.h"
#include "sanitized.h"
#include "uwsim/dynamics/contact_finder.h"

// Law: on a plane divided into many triangles, a body moves as on a single triangle, regardless of the slope, the cells
// and the diagonals.
namespace uwsim {
namespace {

constexpr double kDepth_m = 64;

/// A plane through (0, 0, -kDepth_m) that rises by `rise_x` and `rise_y` per metre.
struct Plane {
  double rise_x = 0, rise_y = 0;

  double height_m(double x_m, double y_m) const { return -kDepth_m + rise_x * x_m + rise_y * y_m; }
  Eigen::Vector3d up() const { return Eigen::Vector3d(-rise_x, -rise_y, 1).normalized(); }
  Eigen::Quaterniond tilt() const { return Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), up()); }
};

/// Grid heights are floats. This slope is close to `angle_deg` and makes the heights of all nodes exact.
double exact_rise(double angle_deg, double spacing_m) {
  return std::round(std::tan(angle_deg * std::numbers::pi / 180) * spacing_m * 65536) / 65536 / spacing_m;
}

struct Grid {
  std::size_t nx, ny;
  Eigen::Vector2d origin_m;
};

/// Nodes at integer multiples of the spacing, from 1 m behind the start to 8 m ahead.
Grid strip(double spacing_m) {
  const double low_x = std::floor(-1 / spacing_m), low_y = std::floor(-1.5 / spacing_m);
  return {static_cast<std::size_t>(std::ceil(8 / spacing_m) - low_x) + 1,
          static_cast<std::size_t>(std::ceil(3.5 / spacing_m) - low_y) + 1, Eigen::Vector2d(low_x, low_y) * spacing_m};
}

World terrain(const Plane& plane, double spacing_m) {
  const Grid grid = strip(spacing_m);
  std::vector<float> heights;
  for (std::size_t j = 0; j < grid.ny; ++j) {
    for (std::size_t i = 0; i < grid.nx; ++i) {
      heights.push_back(static_cast<float>(plane.height_m(grid.origin_m.x() + static_cast<double>(i) * spacing_m,
                                                          grid.origin_m.y() + static_cast<double>(j) * spacing_m)));
    }
  }
  World world;
  world.set_terrain(Heightfield(heights, grid.nx, grid.ny, spacing_m, grid.origin_m));
  return world;
}

World solid(const Plane& plane, double spacing_m, bool other_diagonal) {
  const Grid grid = strip(spacing_m);
  TriangleMesh mesh;
  const auto row = static_cast<std::uint32_t>(grid.nx);
  for (std::uint32_t j = 0; j < grid.ny; ++j) {
    for (std::uint32_t i = 0; i < grid.nx; ++i) {
      const double x = grid.origin_m.x() + i * spacing_m, y = grid.origin_m.y() + j * spacing_m;
      mesh.vertices_m.emplace_back(x, y, plane.height_m(x, y));
      const std::uint32_t k = j * row + i;
      if (i + 1 == grid.nx || j + 1 == grid.ny) continue;
      if (other_diagonal) {
        mesh.triangles.insert(mesh.triangles.end(), {{k, k + 1, k + row + 1}, {k, k + row + 1, k + row}});
      } else {
        mesh.triangles.insert(mesh.triangles.end(), {{k, k + 1, k + row}, {k + 1, k + row + 1, k + row}});
      }
    }
  }
  return solid_world(mesh);
}

World one_triangle(const Plane& plane) {
  TriangleMesh mesh;
  for (const auto& [x, y] : {std::pair{-300.0, -300.0}, {900.0, -300.0}, {-300.0, 900.0}})
    mesh.vertices_m.emplace_back(x, y, plane.height_m(x, y));
  mesh.triangles.push_back({0, 1, 2});
  return solid_world(mesh);
}

struct Shape {
  std::string name;
  TriangleMesh mesh;
};

const std::vector<Shape>& shapes() {
  static const std::vector<Shape> all = {{"sphere", testing::sphere(0.3, 8)},
                                         {"box", brick()},
                                         {"hull", testing::stretched(testing::sphere(0.3, 6), {1.7, 1, 0.8})}};
  return all;
}

/// Of twice the water's density; one that does not turn has a vast inertia.
std::shared_ptr<const Craft> craft(const TriangleMesh& mesh, bool turns) {
  CraftParameters p = solid_of(mesh, 2000);
  if (!turns) p.inertia_kg_m2 *= 1e9 / 2000;
  return craft_of(p, mesh);
}

struct Slide {
  double speed_m_s, friction;
  bool turns = true;
};

/// Places a body 0.2 mm closer to the plane than it would rest, moving along the plane.
BodyState start(const Plane& plane, const TriangleMesh& mesh, const Slide& slide) {
  double lowest_m = 0;
  for (const Eigen::Vector3d& v : mesh.vertices_m) lowest_m = std::min(lowest_m, v.z());
  BodyState state =
      at(Eigen::Vector3d(0.137, 0.061, plane.height_m(0.137, 0.061)) + (0.8 * kRestGap_m - lowest_m) * plane.up());
  state.world_from_body.orientation = plane.tilt();
  const double turn_rad_s = slide.turns ? slide.speed_m_s : 0;
  state.velocity_body << slide.speed_m_s * Eigen::Vector3d(0.94, 0.34, 0),
      turn_rad_s * Eigen::Vector3d(0.02, 0.1, 0.05);
  return state;
}

/// The largest difference between two motions: velocities relative to the speed, positions relative to the distance
/// travelled.
double largest_difference(const World& many, const World& one, const Plane& plane, const TriangleMesh& mesh,
                          const Slide& slide) {
  RigidBodyWorld on_many(many, kStep_s), on_one(one, kStep_s);
  const auto body = craft(mesh, slide.turns);
  const BodyState first = start(plane, mesh, slide);
  for (RigidBodyWorld* world : {&on_many, &on_one}) world->add_body(body_of(body, slide.friction), first);
  double largest = 0, way_m = 0.1;
  int touches = 0;
  for (int k = 0; k < 120; ++k) {
    on_many.step(EvenWater{}, 0);
    on_one.step(EvenWater{}, 0);
    touches += on_many.in_contact(0);
    const BodyState &got = on_many.state(0), &expected = on_one.state(0);
    const double speed = expected.linear_body_m_s().norm();
    way_m += speed * kStep_s;
    largest = std::max({largest, (got.velocity_body - expected.velocity_body).norm() / std::max(speed, 0.01),
                        (got.world_from_body.position_m - expected.world_from_body.position_m).norm() / way_m});
    if (expected.world_from_body.position_m.x() > 7) break;
  }
  EXPECT_GT(touches, 0);
  return largest;
}

// Sanitizers make this slow, so fewer beds and slides are used with them.
const std::vector<double> kSpacings_m = kSanitized ? std::vector{0.5, 50.0} : std::vector{0.1, 0.5, 2.0, 50.0};
const std::vector<Slide> kSlides =
    kSanitized ? std::vector<Slide>{{9, 0}, {0.5, 0.4}} : std::vector<Slide>{{0.5, 0}, {9, 0}, {0.5, 0.4}, {5, 0.4}};

TEST(TessellatedBed, BodiesMoveOnExactTerrainAsOnOneTriangle) {
  for (const double spacing_m : kSpacings_m) {
    for (const double angle_deg : {0.0, 10.0, 28.0, 45.0}) {
      const Plane plane{-exact_rise(angle_deg, spacing_m), exact_rise(angle_deg / 7, spacing_m)};
      const World many = terrain(plane, spacing_m), one = one_triangle(plane);
      for (const Shape& shape : shapes()) {
        for (const Slide& slide : kSlides) {
          EXPECT_LT(largest_difference(many, one, plane, shape.mesh, slide), 1e-6)
              << shape.name << ", cells of " << spacing_m << " m, " << angle_deg << " degrees, " << slide.speed_m_s
              << " m/s, friction " << slide.friction;
        }
      }
    }
  }
}

TEST(TessellatedBed, BodiesMoveOnASolidsFacesAsOnOneTriangle) {
  for (const double spacing_m : kSpacings_m) {
    for (const double angle_deg : {0.0, 28.3, 44.9}) {
      const Plane plane{-std::tan(angle_deg * std::numbers::pi / 180), 0.1};
      const World one = one_triangle(plane);
      const std::array many = {solid(plane, spacing_m, false), solid(plane, spacing_m, true)};
      std::size_t diagonal = 0;  // the two take turns, so that each shape and each slide meets both
      for (const Shape& shape : shapes()) {
        for (const Slide& slide : kSlides) {
          EXPECT_LT(largest_difference(many[diagonal], one, plane, shape.mesh, slide), 1e-6)
              << shape.name << ", cells of " << spacing_m << " m, diagonal " << diagonal << ", " << angle_deg
              << " degrees, " << slide.speed_m_s << " m/s, friction " << slide.friction;
          diagonal = 1 - diagonal;
        }
        diagonal = 1 - diagonal;
      }
    }
  }
}

TEST(TessellatedBed, HeightsThatFloatsRoundCauseNoMoreThanTheirRounding) {
  for (const double spacing_m : {0.1, 0.5}) {
    // Two nodes, on either side of a cell, that are off by half a unit in the last place. Only bodies that do not
    // rotate are used, because a polyhedron that rolls from facet to facet amplifies the smallest difference.
    const double tilt_rad = std::numeric_limits<float>::epsilon() * kDepth_m / spacing_m;
    for (const double angle_deg : {27.0, 28.3, 44.9}) {
      const Plane plane{-std::tan(angle_deg * std::numbers::pi / 180), 0.1};
      const World many = terrain(plane, spacing_m), one = one_triangle(plane);
      for (const Shape& shape : shapes()) {
        for (const double speed_m_s : {0.5, 9.0}) {
          EXPECT_LT(largest_difference(many, one, plane, shape.mesh, {speed_m_s, 0, false}), 10 * tilt_rad)
              << shape.name << ", cells of " << spacing_m << " m, " << angle_deg << " degrees, " << speed_m_s << " m/s";
        }
      }
    }
  }
}

// Actual edges and peaks of the bed do affect bodies.

template <typename Height>
World surface(const Height& height_m) {
  return bed_world(41, 1, height_m);
}

/// The height of a box of 1.2 x 0.8 x 0.6 m, rotated by `yaw_rad`, that has sunk onto a surface for 2 s.
double height_at_rest_m(const World& world, double yaw_rad) {
  CraftParameters p;
  p.mass_kg = 1150;
  p.inertia_kg_m2 = 500 * Eigen::Matrix3d::Identity();
  p.linear_damping.diagonal() << 2000, 2000, 2000, 50'000, 50'000, 50'000;  // too slow to topple in this time
  RigidBodyWorld bodies(world, kStep_s);
  BodyState state = at(0, 0, -19.5);
  state.world_from_body.orientation = Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ());
  bodies.add_body(body_of(craft_of(p), 0.9, 0), state);
  run(bodies, 400);
  EXPECT_TRUE(bodies.in_contact(0));
  return place_m(bodies).z();
}

TEST(TessellatedBed, ABoxRestsOnWhatIsUnderItsFace) {
  const World beds[] = {surface([](double x, double) { return -20 - 0.5 * std::abs(x); }),             // a ridge
                        surface([](double x, double y) { return x == 0 && y == 0 ? -20.0 : -21.0; }),  // a peak
                        solid_world(testing::moved(testing::box(0.02, 3, 0.5), {0, 0, -20.25}), "wall"),
                        solid_world(testing::moved(testing::box(0.1, 0.1, 0.5), {0, 0, -20.25}), "post")};
  for (const World& bed : beds) {
    const auto number = &bed - beds;
    for (const double yaw_rad : number % 2 == 0 ? std::vector{0.0, 0.3, 1.2} : std::vector{0.4})
      EXPECT_NEAR(height_at_rest_m(bed, yaw_rad), -19.7, 0.003) << number << ", " << yaw_rad;
  }
}

TEST(TessellatedBed, ABodyLosesTheSpeedAcrossAHollowEdge) {
  // Without friction or restitution, a body with speed u before a ramp of angle a has speed u cos a on it.
  constexpr double kRise = 0.75;
  const World ramp = surface([](double x, double) { return -20 + kRise * std::max(0.0, x); });
  const TriangleMesh mesh = testing::sphere(0.3, 12);
  RigidBodyWorld bodies(ramp, kStep_s);
  BodyState state = at(-2, 0.3, -19.7 + kRestGap_m);
  state.velocity_body(0) = 3;
  CraftParameters p = solid_of(mesh, 1000);             // neutrally buoyant, so that nothing else slows it down
  p.inertia_kg_m2 = 1e6 * Eigen::Matrix3d::Identity();  // or rotates it
  bodies.add_body(body_of(craft_of(p, mesh), 0, 0), state);
  run(bodies, 200);
  const double cosine = 1 / std::hypot(1, kRise);
  const Eigen::Vector3d left = bodies.state(0).linear_body_m_s();
  EXPECT_NEAR(left.norm(), 3 * cosine, 0.03);
  EXPECT_NEAR(left.z() / left.x(), kRise, 0.02);
}

}  // namespace
}  // namespace uwsim
