#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "dynamics/bodies.h"
#include "meshes.h"
#include "uwsim/dynamics/rigid_body_world.h"

// Laws for Bullet's own dynamics, next to ours, and its limits.
namespace uwsim {
namespace {

constexpr EngineKind kEngines[] = {EngineKind::kUwsim, EngineKind::kBullet};

CraftParameters block_parameters(double density_kg_m3) {
  const SolidProperties solid = solid_properties(testing::box(1.2, 0.8, 0.6));
  CraftParameters p;
  p.mass_kg = density_kg_m3 * solid.volume_m3;
  p.inertia_kg_m2 = density_kg_m3 * solid.inertia_per_density_m5;
  return p;
}

std::shared_ptr<const Craft> block(const CraftParameters& p) {
  return std::make_shared<const Craft>(p, BuoyantHull(testing::box(1.2, 0.8, 0.6)));
}

/// A bed at z = -20 + unevenness_m * sin(1.3 x) cos(0.9 y), with nodes 0.5 m apart.
World bed(double unevenness_m = 0) {
  std::vector<float> heights;
  for (int j = 0; j < 41; ++j) {
    for (int i = 0; i < 41; ++i)
      heights.push_back(static_cast<float>(-20 + unevenness_m * std::sin(0.65 * (i - 20)) * std::cos(0.45 * (j - 20))));
  }
  World world;
  world.set_terrain(Heightfield(heights, 41, 41, 0.5, {-10, -10}));
  return world;
}

BodySpec body(std::shared_ptr<const Craft> craft, double friction = 0.6, double restitution = 0) {
  return {"body", std::move(craft), CollisionShape::kHull, friction, restitution};
}

/// The state of a single body after `steps` steps.
BodyState flown(EngineKind engine, const World& world, const BodySpec& spec, const BodyState& start, int steps) {
  RigidBodyWorld bodies(world, kStep_s, engine);
  bodies.add_body(spec, start);
  for (int k = 0; k < steps; ++k) bodies.step(EvenWater{}, 0);
  return bodies.state(0);
}

TEST(BulletEngine, ABodyWithoutAddedMassTumblesAsItDoesWithOurs) {
  CraftParameters p = block_parameters(1000);
  p.centre_of_mass_body_m = {0.1, -0.05, -0.1};
  p.inertia_kg_m2(0, 1) = p.inertia_kg_m2(1, 0) = 5;
  BodyState start = at(0, 0, -50);
  start.velocity_body << 1, 0.2, -0.1, 0.3, 0.5, 0.2;
  const BodySpec spec = body(block(p));
  const BodyState ours = flown(EngineKind::kUwsim, World{}, spec, start, 400);
  const BodyState bullets = flown(EngineKind::kBullet, World{}, spec, start, 400);
  EXPECT_LT((ours.world_from_body.position_m - bullets.world_from_body.position_m).norm(), 1e-3);
  EXPECT_LT(ours.world_from_body.orientation.angularDistance(bullets.world_from_body.orientation), 5e-3);
  EXPECT_LT((ours.velocity_body - bullets.velocity_body).norm(), 5e-3);
}

TEST(BulletEngine, AddedMassBecomesItsMeanOverAllDirections) {
  Vector6d push = Vector6d::Zero();
  push[2] = 100;
  for (const double heave_kg : {300.0, 900.0}) {  // isotropic, in which case nothing is lost, and anisotropic
    CraftParameters p = block_parameters(1000);
    p.added_mass.diagonal() << 300, 300, heave_kg, 10, 20, 30;
    for (const EngineKind engine : kEngines) {
      RigidBodyWorld bodies(World{}, kStep_s, engine);
      bodies.add_body(body(block(p)), at(0, 0, -50));
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
    const auto craft = block(block_parameters(2000));
    for (std::size_t k = 0; k < 4; ++k)
      bodies.add_body(body(craft), at(0, 0, -19.699 + 0.602 * static_cast<double>(k)));
    for (int k = 0; k < 600; ++k) bodies.step(EvenWater{}, 0);
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
  const auto craft = block(block_parameters(1000));
  for (const double restitution : {0.0, 0.5, 0.8}) {
    for (const EngineKind engine : kEngines) {
      RigidBodyWorld bodies(World{}, kStep_s, engine);
      BodyState coming = at(-1.5, 0, -20);
      coming.velocity_body(0) = 1;
      bodies.add_body(body(craft, 0.5, restitution), coming);
      bodies.add_body(body(craft, 0.5, restitution), at(0, 0, -20));
      for (int k = 0; k < 100; ++k) bodies.step(EvenWater{}, 0);
      const double parting_m_s = bodies.state(1).velocity_body(0) - bodies.state(0).velocity_body(0);
      EXPECT_NEAR(parting_m_s, restitution, 0.01) << restitution;
    }
  }
}

TEST(BulletEngine, ABodySlidesDownARampByCoulombsLaw) {
  const double slope = std::atan(0.3);
  const Eigen::Quaterniond tilt(Eigen::AngleAxisd(-slope, Eigen::Vector3d::UnitY()));
  TriangleMesh ramp = testing::box(20, 20, 2);
  for (auto& v : ramp.vertices_m) v = tilt * v + Eigen::Vector3d(0, 0, -30);
  World world;
  world.add_solid("ramp", ramp);
  BodyState start;
  start.world_from_body.position_m = Eigen::Vector3d(0, 0, -30) + tilt * Eigen::Vector3d(5, 0.3, 1.301);
  start.world_from_body.orientation = tilt;
  const auto craft = block(block_parameters(3000));
  for (const EngineKind engine : kEngines) {
    const auto slid_m = [&](double friction) {
      const BodyState end = flown(engine, world, body(craft, friction), start, 400);
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
  const auto craft = block(block_parameters(2500));
  for (const double x : {-3.2, 0.3, 2.6}) {
    BodyState start = at(x, 1.1, -19.3);
    const World world = bed(0.3);
    const double ours_m = flown(EngineKind::kUwsim, world, body(craft, 2), start, 800).world_from_body.position_m.z();
    const double bullets_m =
        flown(EngineKind::kBullet, world, body(craft, 2), start, 800).world_from_body.position_m.z();
    EXPECT_NEAR(ours_m, bullets_m, 0.02) << x;
  }
}

TEST(BulletEngine, EqualStatesHaveEqualFutures) {
  const World world = bed(0.3);
  const BodySpec spec = body(block(block_parameters(2000)));
  RigidBodyWorld bodies(world, kStep_s, EngineKind::kBullet), other(world, kStep_s, EngineKind::kBullet);
  for (const double z : {-19.2, -18.5, -17.8}) {
    bodies.add_body(spec, at(0.4, 0.3, z));
    other.add_body(spec, at(2 + z / 5, 5, z));
  }
  for (int k = 0; k < 200; ++k) {
    bodies.step(EvenWater{}, 0);
    other.step(EvenWater{}, 0);
  }
  other.change_bodies({spec, spec, spec}, Water());
  StateArchive saved;
  bodies.exchange_state(saved);
  bodies.exchange_contacts(saved);
  StateArchive restored(saved.bytes());
  other.exchange_state(restored);  // where it has a different history
  other.exchange_contacts(restored);
  StateArchive again;
  other.exchange_state(again);
  other.exchange_contacts(again);
  EXPECT_EQ(again.bytes(), saved.bytes());
  for (int k = 0; k < 200; ++k) {
    bodies.step(EvenWater{}, 0);
    other.step(EvenWater{}, 0);
    for (std::size_t body = 0; body < 3; ++body) {
      ASSERT_EQ(bodies.state(body).velocity_body, other.state(body).velocity_body) << "step " << k;
      ASSERT_EQ(bodies.state(body).world_from_body.position_m, other.state(body).world_from_body.position_m);
    }
  }
}

TEST(BulletEngine, TwoBodiesConserveMomentumAndAHeldOneDoesNotCollide) {
  const auto craft = block(block_parameters(1000));
  for (const bool held : {false, true}) {
    RigidBodyWorld bodies(World{}, kStep_s, EngineKind::kBullet);
    BodyState left = at(-1.5, 0, -20);
    left.velocity_body(0) = 1;
    bodies.add_body(body(craft, 0.5, 0.3), left);
    bodies.add_body(body(craft, 0.5, 0.3), at(0.5, 0.1, -20));
    bodies.hold(1, held);
    for (int k = 0; k < 400; ++k) bodies.step(EvenWater{}, 0);
    const auto velocity = [&](std::size_t k) -> Eigen::Vector3d {
      return bodies.state(k).world_from_body.direction(bodies.state(k).linear_body_m_s());
    };
    EXPECT_LT((velocity(0) + velocity(1) - Eigen::Vector3d(1, 0, 0)).norm(), 1e-9);
    EXPECT_EQ(velocity(1).x() == 0, held);
  }
}

}  // namespace
}  // namespace uwsim
