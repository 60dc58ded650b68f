#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "dynamics/bodies.h"

// Laws for Bullet's own dynamics, next to ours, and its limits.
namespace uwsim {
namespace {

/// A bed at z = -20 + unevenness_m * sin(1.3 x) cos(0.9 y), with nodes 0.5 m apart.
World bed(double unevenness_m = 0) {
  return bed_world(41, 0.5,
                   [&](double x, double y) { return -20 + unevenness_m * std::sin(1.3 * x) * std::cos(0.9 * y); });
}

BodySpec body(const CraftParameters& p, double friction = 0.6, double restitution = 0) {
  return body_of(craft_of(p), friction, restitution);
}

/// The state of a single body after `steps` steps.
BodyState flown(EngineKind engine, const World& world, const BodySpec& spec, const BodyState& start, int steps) {
  RigidBodyWorld bodies(world, kStep_s, engine);
  bodies.add_body(spec, start);
  run(bodies, steps);
  return bodies.state(0);
}

TEST(BulletEngine, ABodyWithoutAddedMassTumblesAsItDoesWithOurs) {
  CraftParameters p = brick_parameters(1000);
  p.centre_of_mass_body_m = {0.1, -0.05, -0.1};
  p.inertia_kg_m2(0, 1) = p.inertia_kg_m2(1, 0) = 5;
  BodyState start = at(0, 0, -50);
  start.velocity_body << 1, 0.2, -0.1, 0.3, 0.5, 0.2;
  const BodySpec spec = body(p);
  const BodyState ours = flown(EngineKind::kUwsim, World{}, spec, start, 400);
  const BodyState bullets = flown(EngineKind::kBullet, World{}, spec, start, 400);
  EXPECT_LT((ours.world_from_body.position_m - bullets.world_from_body.position_m).norm(), 1e-3);
  EXPECT_LT(ours.world_from_body.orientation.angularDistance(bullets.world_from_body.orientation), 5e-3);
  EXPECT_LT((ours.velocity_body - bullets.velocity_body).norm(), 5e-3);
}

TEST(BulletEngine, AddedMassBecomesItsMeanOverAllDirections) {
  const Vector6d push(0, 0, 100, 0, 0, 0);
  for (const double heave_kg : {300.0, 900.0}) {  // isotropic, in which case nothing is lost, and anisotropic
    CraftParameters p = brick_parameters(1000);
    p.added_mass.diagonal() << 300, 300, heave_kg, 10, 20, 30;
    for (const EngineKind engine : kEngines) {
      RigidBodyWorld bodies(World{}, kStep_s, engine);
      bodies.add_body(body(p), at(0, 0, -50));
      bodies.set_wrench(0, push);
      bodies.step(EvenWater{}, 0);
      const double added_kg = engine == EngineKind::kUwsim ? heave_kg : (600 + heave_kg) / 3;
      EXPECT_NEAR(bodies.state(0).velocity_body[2], 100 * kStep_s / (p.mass_kg + added_kg), 1e-9) << heave_kg;
    }
  }
}

TEST(BulletEngine, AStackOfBoxesStands) {
  for (const EngineKind engine : kEngines) {
    RigidBodyWorld bodies(bed(), kStep_s, engine);
    const CraftParameters block = brick_parameters(2000);
    for (std::size_t k = 0; k < 4; ++k)
      bodies.add_body(body(block), at(0, 0, -19.699 + 0.602 * static_cast<double>(k)));
    run(bodies, 600);
    for (std::size_t k = 0; k < 4; ++k) {
      const BodyState& state = bodies.state(k);
      EXPECT_LT((state.world_from_body.position_m - Eigen::Vector3d(0, 0, -19.7 + 0.6 * static_cast<double>(k))).norm(),
                5e-3);
      EXPECT_LT(state.velocity_body.norm(), 3e-3);
      EXPECT_TRUE(bodies.in_contact(k));
    }
  }
}

TEST(BulletEngine, TwoBodiesPartByNewtonsRestitution) {
  const CraftParameters block = brick_parameters(1000);
  for (const double restitution : {0.0, 0.5, 0.8}) {
    for (const EngineKind engine : kEngines) {
      RigidBodyWorld bodies(World{}, kStep_s, engine);
      BodyState coming = at(-1.5, 0, -20);
      coming.velocity_body(0) = 1;
      bodies.add_body(body(block, 0.5, restitution), coming);
      bodies.add_body(body(block, 0.5, restitution), at(0, 0, -20));
      run(bodies, 100);
      const double parting_m_s = bodies.state(1).velocity_body(0) - bodies.state(0).velocity_body(0);
      EXPECT_NEAR(parting_m_s, restitution, 0.01) << restitution;
    }
  }
}

TEST(BulletEngine, ABodySlidesDownARampByCoulombsLaw) {
  const double slope = std::atan(0.3);
  const Eigen::Quaterniond tilt(Eigen::AngleAxisd(-slope, Eigen::Vector3d::UnitY()));
  const Pose pose{{0, 0, -30}, tilt};
  const World world = solid_world(testing::placed(testing::box(20, 20, 2), pose), "ramp");
  BodyState start = at(pose.point({5, 0.3, 1.301}));
  start.world_from_body.orientation = tilt;
  const CraftParameters block = brick_parameters(3000);
  for (const EngineKind engine : kEngines) {
    const auto slid_m = [&](double friction) {
      const BodyState end = flown(engine, world, body(block, friction), start, 400);
      return (end.world_from_body.position_m - start.world_from_body.position_m).norm();
    };
    const double weight = 9.80665 * 2 / 3;  // per mass, in water
    for (const double friction : {0.0, 0.1}) {
      const double expected_m = 0.5 * weight * (std::sin(slope) - friction * std::cos(slope)) * 4;
      EXPECT_NEAR(slid_m(friction), expected_m, 0.015 * expected_m) << friction;
    }
    EXPECT_LT(slid_m(0.6), 1e-3);
  }
}

TEST(BulletEngine, ABodyRestsOnTheSameTerrain) {
  const CraftParameters block = brick_parameters(2500);
  for (const double x : {-3.2, 0.3, 2.6}) {
    BodyState start = at(x, 1.1, -19.3);
    const World world = bed(0.3);
    const double ours_m = flown(EngineKind::kUwsim, world, body(block, 2), start, 800).world_from_body.position_m.z();
    const double bullets_m =
        flown(EngineKind::kBullet, world, body(block, 2), start, 800).world_from_body.position_m.z();
    EXPECT_NEAR(ours_m, bullets_m, 0.02) << x;
  }
}

TEST(BulletEngine, EqualStatesHaveEqualFutures) {
  const World world = bed(0.3);
  const BodySpec spec = body(brick_parameters(2000));
  for (const EngineKind engine : kEngines) {
    RigidBodyWorld bodies(world, kStep_s, engine), other(world, kStep_s, engine);
    for (const double z : {-19.2, -18.5, -17.8}) {
      bodies.add_body(spec, at(0.4, 0.3, z));
      other.add_body(spec, at(2 + z / 5, 5, z));
    }
    for (RigidBodyWorld* each : {&bodies, &other}) run(*each, 200);
    other.change_bodies({spec, spec, spec});
    const std::string middle = saved(bodies);
    restore(other, middle);  // where it has a different history
    EXPECT_EQ(saved(other), middle);
    for (int k = 0; k < 200; ++k) {
      for (RigidBodyWorld* each : {&bodies, &other}) each->step(EvenWater{}, k * kStep_s);
      ASSERT_EQ(saved(bodies), saved(other)) << "step " << k;
    }
  }
}

TEST(BulletEngine, TwoBodiesConserveMomentumAndAHeldOneNeitherMovesNorCollides) {
  const CraftParameters block = brick_parameters(1000);
  for (const EngineKind engine : kEngines) {
    for (const bool held : {false, true}) {
      RigidBodyWorld bodies(World{}, kStep_s, engine);
      BodyState left = at(-1.5, 0, -20);
      left.velocity_body(0) = 1;
      bodies.add_body(body(block, 0.5, 0.3), left);
      bodies.add_body(body(block, 0.5, 0.3), at(0.5, 0.1, -20));
      bodies.hold(1, held);
      run(bodies, 400);
      // Ours separates an overlap, which turns the bodies slightly, and their velocities with them.
      const double tolerance = engine == EngineKind::kUwsim && !held ? 2e-3 : 1e-9;
      EXPECT_LT((velocity_m_s(bodies, 0) + velocity_m_s(bodies, 1) - Eigen::Vector3d(1, 0, 0)).norm(), tolerance);
      EXPECT_EQ(velocity_m_s(bodies, 1).x() == 0, held);
      EXPECT_EQ(place_m(bodies, 1) == Eigen::Vector3d(0.5, 0.1, -20), held);
      if (!held) {
        EXPECT_LT(velocity_m_s(bodies, 0).x(), velocity_m_s(bodies, 1).x()) << "they part";
      }
    }
  }
}

}  // namespace
}  // namespace uwsim
