#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "dynamics/bodies.h"

// Round bodies roll as in textbooks: without slip nothing brakes them, and friction turns sliding into rolling.
namespace uwsim {
namespace {

constexpr double kRound_m = 0.3, kHalfLong_m = 0.4, kFlatBed_m = -10;

struct RoundCase {
  const char* name;
  double gyration;  ///< squared radius of gyration about the axis of rolling, over the squared radius
  TriangleMesh mesh;
  RoundPiece exact;
};

/// A drum along y.
TriangleMesh faceted_drum(int sides) {
  TriangleMesh mesh;
  for (int k = 0; k < sides; ++k) {
    const double angle = 2 * std::numbers::pi * k / sides;
    for (const double y : {-kHalfLong_m, kHalfLong_m})
      mesh.vertices_m.emplace_back(kRound_m * std::cos(angle), y, kRound_m * std::sin(angle));
  }
  const auto at = [&](int k, int end) { return static_cast<std::uint32_t>(2 * (k % sides) + end); };
  for (int k = 0; k < sides; ++k) {
    mesh.triangles.push_back({at(k, 0), at(k, 1), at(k + 1, 1)});
    mesh.triangles.push_back({at(k, 0), at(k + 1, 1), at(k + 1, 0)});
    if (k < 2) continue;
    mesh.triangles.push_back({at(0, 0), at(k - 1, 0), at(k, 0)});
    mesh.triangles.push_back({at(0, 1), at(k, 1), at(k - 1, 1)});
  }
  return mesh;
}

std::vector<RoundCase> round_cases() {
  const Eigen::Vector3d half = {0, kHalfLong_m, 0};
  return {{"ball", 0.4, testing::sphere(kRound_m, 16), {.radius_m = kRound_m}},
          {"rod", 0.45, faceted_drum(32), {.half_axis_m = half, .radius_m = kRound_m}},
          {"drum", 0.5, faceted_drum(32), {.half_axis_m = half, .radius_m = kRound_m, .has_flat_ends = true}}};
}

BodySpec round_body(const RoundCase& round, double friction = 0.6) {
  CraftParameters p;
  p.mass_kg = 100;
  p.inertia_kg_m2 = p.mass_kg * kRound_m * kRound_m * round.gyration * Eigen::Matrix3d::Identity();
  BodySpec spec = body_of(craft_of(p, round.mesh), friction);
  spec.round = round.exact;
  return spec;
}

/// Along x, rolling without slip if `rolls`.
BodyState moving(const Eigen::Vector3d& place_m, double speed_m_s, bool rolls) {
  BodyState state = at(place_m);
  state.velocity_body << speed_m_s, 0, 0, 0, rolls ? speed_m_s / kRound_m : 0, 0;
  return state;
}

World slope(double rise) {
  return bed_world(161, 0.5, [=](double x, double) { return kFlatBed_m + rise * x; });
}

TEST(Rolling, WithoutSlipNothingBrakes) {
  for (const RoundCase& round : round_cases()) {
    for (const double speed_m_s : {0.5, 2.0}) {
      RigidBodyWorld bodies(slope(0), kStep_s);
      bodies.add_body(round_body(round), moving({-15, 0.13, kFlatBed_m + kRound_m}, speed_m_s, true));
      run(bodies, 2000, vacuum());
      EXPECT_NEAR(velocity_m_s(bodies).x(), speed_m_s, 2e-3 * speed_m_s) << round.name;
      EXPECT_NEAR(bodies.state(0).angular_body_rad_s().norm() * kRound_m, speed_m_s, 2e-3 * speed_m_s) << round.name;
      EXPECT_NEAR(place_m(bodies).x(), -15 + 10 * speed_m_s, 0.02 * speed_m_s) << round.name;
      EXPECT_NEAR(place_m(bodies).y(), 0.13, 1e-3) << round.name;
      EXPECT_NEAR(place_m(bodies).z(), kFlatBed_m + kRound_m, 1.1e-3) << round.name;
    }
  }
}

/// a = g sin(slope) / (1 + k^2 / r^2): 5/7 for a ball, 2/3 for a drum.
TEST(Rolling, DownASlopeItSpeedsUpByItsInertia) {
  for (const RoundCase& round : round_cases()) {
    for (const double rise : {-0.1, -0.3}) {
      RigidBodyWorld bodies(slope(rise), kStep_s);
      const double stretch = std::hypot(1, rise);
      BodyState state = at(-20, 0.13, kFlatBed_m - 20 * rise + kRound_m * stretch);
      bodies.add_body(round_body(round), state);
      run(bodies, 100, vacuum());
      const double early_m_s = velocity_m_s(bodies).norm();
      run(bodies, 400, vacuum());
      const double got = (velocity_m_s(bodies).norm() - early_m_s) / (400 * kStep_s);
      const double expected = kGravity * -rise / stretch / (1 + round.gyration);
      EXPECT_NEAR(got, expected, 0.005 * expected) << round.name << " " << rise;
    }
  }
}

/// v = v_0 / (1 + k^2 / r^2): 5/7 for a ball, 2/3 for a drum.
TEST(Rolling, FrictionTurnsSlidingIntoRolling) {
  for (const RoundCase& round : round_cases()) {
    for (const double friction : {0.1, 0.6}) {
      RigidBodyWorld bodies(slope(0), kStep_s);
      bodies.add_body(round_body(round, friction), moving({-15, 0.13, kFlatBed_m + kRound_m}, 2, false));
      run(bodies, 600, vacuum());
      const double expected = 2 / (1 + round.gyration);
      EXPECT_NEAR(velocity_m_s(bodies).x(), expected, 0.005 * expected) << round.name << " " << friction;
      EXPECT_NEAR(bodies.state(0).angular_body_rad_s().norm() * kRound_m, expected, 0.005 * expected) << round.name;
    }
  }
}

/// A ridge and a box's edge turn a ball's path without taking speed: it rolls round them, at the height of its radius.
TEST(Rolling, ABallRestsOnAnEdgeByItsRadius) {
  const World world = solid_world(testing::moved(testing::box(2, 4, 1), {0, 0, kFlatBed_m}));
  RigidBodyWorld bodies(world, kStep_s);
  bodies.add_body(round_body(round_cases()[0]), moving({0.5, 0, kFlatBed_m + 0.5 + kRound_m}, 0.5, true));
  double nearest_m = 1;
  while (place_m(bodies).z() > kFlatBed_m) {
    bodies.step(vacuum(), 0);
    const Eigen::Vector3d from_edge = place_m(bodies) - Eigen::Vector3d(1, 0, kFlatBed_m + 0.5);
    nearest_m = std::min(nearest_m, std::hypot(from_edge.x(), from_edge.z()));
  }
  EXPECT_NEAR(nearest_m, kRound_m, 2e-3);
}

TEST(Rolling, ADrumStandsOnItsEnd) {
  RigidBodyWorld bodies(slope(0), kStep_s);
  BodyState state = at(0.1, 0.2, kFlatBed_m + kHalfLong_m + 0.05);
  state.world_from_body.orientation = Eigen::AngleAxisd(std::numbers::pi / 2 + 0.05, Eigen::Vector3d::UnitX());
  bodies.add_body(round_body(round_cases()[2]), state);
  run(bodies, 2000, vacuum());
  EXPECT_EQ(bodies.state(0).velocity_body.norm(), 0);
  EXPECT_NEAR(place_m(bodies).z(), kFlatBed_m + kHalfLong_m, 1.1e-3);
}

/// At restitution 1, without friction, a ball gives another of its mass what it has along the line of their centres and
/// turns neither; with friction, energy is lost.
TEST(Rolling, TwoBallsMeetOnTheLineOfTheirCentres) {
  for (const double aside_m : {0.0, 0.05, 0.11, 0.23, 0.37, 0.5, 0.59}) {
    for (const double friction : {0.0, 0.2, 0.6}) {
      RigidBodyWorld bodies(World{}, kStep_s);
      for (const bool hit : {false, true}) {
        BodySpec spec = round_body(round_cases()[0], friction);
        spec.restitution = 1;
        bodies.add_body(spec, moving({hit ? 0.01 : -1, hit ? aside_m : 0, 0.03}, hit ? 0 : 1, false));
      }
      run(bodies, 400, vacuum(0));
      double energy = 0;
      for (const std::size_t k : {0U, 1U}) {
        energy += velocity_m_s(bodies, k).squaredNorm();
        energy += 0.4 * kRound_m * kRound_m * bodies.state(k).angular_body_rad_s().squaredNorm();
      }
      EXPECT_LE(energy, 1 + 1e-7) << aside_m << " " << friction;
      EXPECT_NEAR((velocity_m_s(bodies, 0) + velocity_m_s(bodies, 1)).x(), 1, 1e-7) << aside_m << " " << friction;
      if (friction > 0) continue;
      EXPECT_NEAR(energy, 1, 1e-7) << aside_m;
      EXPECT_LT(bodies.state(1).angular_body_rad_s().norm(), 1e-12) << aside_m;
    }
  }
}

}  // namespace
}  // namespace uwsim
