#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <vector>

#include "dynamics/bodies.h"
#include "meshes.h"
#include "uwsim/dynamics/contact_finder.h"
#include "uwsim/dynamics/rigid_body_world.h"

// Laws of contact for RigidBodyWorld, including shapes, contact finder, solver and integrator.
namespace uwsim {
namespace {

CraftParameters box_parameters(double density_kg_m3) {
  const SolidProperties solid = solid_properties(testing::box(1.2, 0.8, 0.6));
  CraftParameters p;
  p.mass_kg = density_kg_m3 * solid.volume_m3;
  p.inertia_kg_m2 = density_kg_m3 * solid.inertia_per_density_m5;
  return p;
}

std::shared_ptr<const Craft> box_craft(const CraftParameters& p) {
  return std::make_shared<const Craft>(p, BuoyantHull(testing::box(1.2, 0.8, 0.6)));
}

World terrain_world(double (*height_m)(double x_m, double y_m), double spacing_m = 0.5) {
  constexpr int kNodes = 121;
  const double edge = -0.5 * (kNodes - 1) * spacing_m;
  std::vector<float> heights;
  for (int j = 0; j < kNodes; ++j) {
    for (int i = 0; i < kNodes; ++i)
      heights.push_back(static_cast<float>(height_m(edge + i * spacing_m, edge + j * spacing_m)));
  }
  World world;
  world.set_terrain(Heightfield(heights, kNodes, kNodes, spacing_m, {edge, edge}));
  return world;
}

double flat(double, double) { return -10; }
double gentle(double x, double) { return -10 + 0.25 * x; }
double rough(double x, double y) { return -10 + 0.3 * std::sin(1.3 * x) * std::cos(0.9 * y) + 0.1 * std::sin(4 * y); }

World solid_world(TriangleMesh mesh, const Pose& pose) {
  for (auto& v : mesh.vertices_m) v = pose.point(v);
  World world;
  world.add_solid("solid", std::move(mesh));
  return world;
}

double mechanical_energy(const Craft& craft, const BodyState& state) {
  const double weight = (craft.parameters().mass_kg - 1000 * craft.hull().solid().volume_m3) * 9.80665;
  return craft.kinetic_energy_j(state) + weight * state.world_from_body.position_m.z();
}

struct Rest {
  double rms_speed = 0;
  double drift_m = 0;
  BodyState end;
};

/// Lets a body settle for `settle` steps, then observes it for 400 steps.
Rest rest(const World& world, std::shared_ptr<const Craft> craft, const BodyState& start, int settle) {
  RigidBodyWorld bodies(world, kStep_s);
  bodies.add_body({"body", std::move(craft), CollisionShape::kHull, 0.6, 0.1}, start);
  for (int k = 0; k < settle; ++k) bodies.step(EvenWater{}, 0);
  const Eigen::Vector3d place = bodies.state(0).world_from_body.position_m;
  double sum = 0;
  for (int k = 0; k < 400; ++k) {
    bodies.step(EvenWater{}, 0);
    sum += bodies.state(0).velocity_body.squaredNorm();
  }
  return {std::sqrt(sum / 400), (bodies.state(0).world_from_body.position_m - place).norm(), bodies.state(0)};
}

CraftParameters sinking_box(double added_mass) {
  CraftParameters p = box_parameters(2000);
  p.added_mass.diagonal() << added_mass, added_mass, added_mass, added_mass / 10, added_mass / 6, added_mass / 5;
  p.linear_damping.diagonal() << 50, 50, 50, 20, 20, 20;
  return p;
}

TEST(Contact, ABodyRestsWithoutJitterWithinAMillimetreOfTheBed) {
  for (const double added : {0.0, 11520.0}) {  // none, and ten times the rigid-body mass
    const Rest on_flat = rest(terrain_world(flat), box_craft(sinking_box(added)), at(0.1, 0.2, -9.5), 2000);
    EXPECT_LT(on_flat.rms_speed, 1e-4) << added;
    EXPECT_NEAR(on_flat.end.world_from_body.position_m.z(), -10 + 0.3 + 0.5 * kRestGap_m, 0.6 * kRestGap_m);
  }
}

TEST(Contact, ABodyRestsWithoutJitterOnASlopeAndOnRoughGround) {
  BodyState start = at(0, 0, -9.6);
  start.world_from_body.orientation = Eigen::AngleAxisd(-std::atan(0.25), Eigen::Vector3d::UnitY());
  const Rest on_slope = rest(terrain_world(gentle), box_craft(sinking_box(500)), start, 2000);
  EXPECT_LT(on_slope.rms_speed, 1e-3);
  EXPECT_LT(on_slope.drift_m, 1e-3);
  const Rest on_rough = rest(terrain_world(rough), box_craft(sinking_box(500)), at(0.4, 0.3, -9), 4000);
  EXPECT_LT(on_rough.rms_speed, 1e-3);
  EXPECT_LT(on_rough.drift_m, 1e-3);
}

TEST(Contact, ABodyRestsOnASolidsMesh) {
  Pose pose;
  pose.position_m = {0, 0, -12};
  const Rest on_box = rest(solid_world(testing::box(3, 3, 1), pose), box_craft(sinking_box(500)), at(0, 0, -11), 2000);
  EXPECT_LT(on_box.rms_speed, 1e-4);
  EXPECT_NEAR(on_box.end.world_from_body.position_m.z(), -11.5 + 0.3, 1.2 * kRestGap_m);
}

TEST(Contact, ABodyThatIsHeldRestsToTheLastBit) {
  BodyState tilted = at(0, 0, -9.6);
  tilted.world_from_body.orientation = Eigen::AngleAxisd(-std::atan(0.25), Eigen::Vector3d::UnitY());
  const Rest ends[] = {rest(terrain_world(flat), box_craft(sinking_box(500)), at(0.1, 0.2, -9.5), 4000),
                       rest(terrain_world(gentle), box_craft(sinking_box(500)), tilted, 4000),
                       rest(terrain_world(rough), box_craft(sinking_box(500)), at(0.4, 0.3, -9), 8000)};
  for (const Rest& end : ends) {
    EXPECT_EQ(end.rms_speed, 0);
    EXPECT_EQ(end.drift_m, 0);
  }
}

/// A box on a flat bed is pulled along x by a force that increases to twice what friction can hold. `forgets`: performs
/// each step in a new world, without memory of earlier steps.
std::vector<double> pulled(bool forgets, int steps) {
  const World world = terrain_world(flat);
  const auto craft = box_craft(sinking_box(500));
  const auto made = [&](const BodyState& state) {
    RigidBodyWorld bodies(world, kStep_s);
    bodies.add_body({"body", craft, CollisionShape::kHull, 0.6, 0.1}, state);
    return bodies;
  };
  RigidBodyWorld bodies = made(at(0.1, 0.2, -9.69));
  for (int k = 0; k < 2000; ++k) bodies.step(EvenWater{}, 0);
  const double held_n = 0.6 * (craft->parameters().mass_kg - 1000 * craft->hull().solid().volume_m3) * 9.80665;
  std::vector<double> places_m;
  for (int k = 0; k < steps; ++k) {
    if (forgets) bodies = made(bodies.state(0));
    Vector6d tau = Vector6d::Zero();
    tau[0] = 2 * held_n * (k / 4 * 4) / steps;  // constant for four steps
    bodies.set_wrench(0, tau);
    bodies.step(EvenWater{}, 0);
    places_m.push_back(bodies.state(0).world_from_body.position_m.x());
  }
  return places_m;
}

TEST(Contact, ABodyAtRestMovesAsSoonAsFrictionIsExceeded) {
  const std::vector<double> places_m = pulled(false, 400);
  for (std::size_t k = 0; k < 200; ++k) EXPECT_EQ(places_m[k], places_m[0]) << k;
  EXPECT_GT(places_m[212], places_m[0]);
  EXPECT_GT(places_m[399] - places_m[0], 0.05);
}

TEST(Contact, WhatIsRememberedOfARestChangesNoBit) { EXPECT_EQ(pulled(false, 400), pulled(true, 400)); }

TEST(Contact, TheImpulseOfAStepIsThatOfTheFullMassMatrix) {
  CraftParameters p = box_parameters(1000);
  p.added_mass.diagonal() << 300, 2000, 4000, 150, 250, 500;
  const auto craft = box_craft(p);
  Matrix6d mass = p.added_mass;
  mass.topLeftCorner<3, 3>() += p.mass_kg * Eigen::Matrix3d::Identity();
  mass.bottomRightCorner<3, 3>() += p.inertia_kg_m2;
  for (const double wall_yaw : {0.0, 0.3}) {  // perpendicular, and oblique, so that a corner hits the wall
    for (const double restitution : {0.0, 0.5, 1.0}) {
      Pose pose;
      pose.position_m = {3, 0, -30};
      pose.orientation = Eigen::AngleAxisd(wall_yaw, Eigen::Vector3d::UnitZ());
      RigidBodyWorld bodies(solid_world(testing::box(0.4, 40, 40), pose), kStep_s);
      BodyState state = at(0, 0, -30);
      // hits with an edge instead of a face
      state.world_from_body.orientation = Eigen::AngleAxisd(0.2, Eigen::Vector3d(0, 1, 0));
      state.velocity_body << state.world_from_body.orientation.conjugate() * Eigen::Vector3d(1.0, 0, 0), 0, 0, 0;
      bodies.add_body({"body", craft, CollisionShape::kHull, 0, restitution}, state);
      BodyState before = state;
      while (!bodies.in_contact(0) && bodies.state(0).world_from_body.position_m.x() < 4) {
        before = bodies.state(0);
        bodies.step(EvenWater{}, 0);
      }
      ASSERT_TRUE(bodies.in_contact(0));
      const Eigen::Matrix3d rotation = before.world_from_body.rotation();
      const Eigen::Vector3d normal = rotation.transpose() * pose.direction(-Eigen::Vector3d::UnitX());
      // The deepest corner, or the middle of the deepest edge.
      Eigen::Vector3d corner = Eigen::Vector3d(0.6, wall_yaw == 0 ? 0 : (wall_yaw > 0 ? 0.4 : -0.4), 0);
      corner.z() = 0.3 * (normal.z() > 0 ? -1 : 1);
      Vector6d j;
      j << normal, corner.cross(normal);
      const double approach = j.dot(before.velocity_body);
      const double response = j.dot(mass.ldlt().solve(j));
      const double expected = -(1 + restitution) * approach / response;
      const Vector6d got = mass * (bodies.state(0).velocity_body - before.velocity_body);
      EXPECT_NEAR(got.head<3>().dot(normal), expected, 0.01 * expected) << wall_yaw << " " << restitution;
    }
  }
}

TEST(Contact, EnergyNeverGrows) {
  CraftParameters p = box_parameters(1500);
  p.added_mass.diagonal() << 300, 3000, 8000, 100, 250, 400;
  const auto craft = box_craft(p);
  for (const double restitution : {0.0, 0.5}) {
    for (const double friction : {0.0, 0.8}) {
      RigidBodyWorld bodies(terrain_world(rough), kStep_s);
      BodyState state = at(0.3, -0.2, -8);
      state.velocity_body << 1.5, 0.4, -1, 0.6, -0.5, 0.8;
      bodies.add_body({"body", craft, CollisionShape::kHull, friction, restitution}, state);
      double energy = mechanical_energy(*craft, state);
      const double scale = craft->kinetic_energy_j(state);
      for (int k = 0; k < 3000; ++k) {
        bodies.step(EvenWater{}, 0);
        const double now = mechanical_energy(*craft, bodies.state(0));
        ASSERT_LT(now, energy + 2e-3 * scale) << "step " << k << " e " << restitution << " mu " << friction;
        energy = std::min(energy, now);
      }
    }
  }
}

TEST(Contact, NoBodyTunnelsThroughASurface) {
  CraftParameters p = box_parameters(1000);
  p.added_mass.diagonal() << 100, 100, 100, 10, 10, 10;
  const auto craft = box_craft(p);
  for (const double speed : {1.6, 5.0, 12.0}) {
    Pose pose;
    pose.position_m = {5, 0, -20};
    RigidBodyWorld bodies(solid_world(testing::box(0.004, 6, 6), pose), kStep_s);
    BodyState state = at(0, 0, -20);
    state.velocity_body(0) = speed;
    bodies.add_body({"body", craft, CollisionShape::kHull, 0, 0}, state);
    for (int k = 0; k < 2000; ++k) {
      bodies.step(EvenWater{}, 0);
      ASSERT_LT(bodies.state(0).world_from_body.position_m.x(), 5 - 0.002 - 0.6) << speed << " step " << k;
    }

    RigidBodyWorld over_ground(terrain_world(rough), kStep_s);
    BodyState diving = at(0, 0, -6);
    diving.world_from_body.orientation = Eigen::AngleAxisd(0.9, Eigen::Vector3d(0.3, 1, 0).normalized());
    diving.velocity_body(0) = speed;
    over_ground.add_body({"body", craft, CollisionShape::kHull, 0.5, 0.1}, diving);
    for (int k = 0; k < 2000; ++k) {
      over_ground.step(EvenWater{}, 0);
      const Eigen::Vector3d& place = over_ground.state(0).world_from_body.position_m;
      if (place.head<2>().cwiseAbs().maxCoeff() > 28) break;
      ASSERT_GT(place.z(), rough(place.x(), place.y()) + 0.2) << speed << " step " << k;
    }
  }
}

TEST(Contact, ABodyPlacedInsideTheGroundIsPushedOutSlowly) {
  for (const double depth_m : {0.2, 3.0}) {
    const auto craft = box_craft(sinking_box(500));
    RigidBodyWorld bodies(terrain_world(rough), kStep_s);
    bodies.add_body({"body", craft, CollisionShape::kHull, 0.6, 0.1}, at(0.4, 0.3, rough(0.4, 0.3) - depth_m));
    double fastest = 0;
    for (int k = 0; k < 1500; ++k) {
      bodies.step(EvenWater{}, 0);
      fastest = std::max(fastest, bodies.state(0).velocity_body.norm());
    }
    const Eigen::Vector3d& place = bodies.state(0).world_from_body.position_m;
    EXPECT_GT(place.z(), rough(place.x(), place.y()) + 0.2);
    EXPECT_LT(fastest, 1.5);
  }
}

TEST(Contact, ABodyOnAFlatMeshSlidesOverTheEdgesBetweenTriangles) {
  CraftParameters p = box_parameters(2000);
  const auto craft = box_craft(p);
  TriangleMesh tiles;
  for (std::uint32_t j = 0; j < 61; ++j) {
    for (std::uint32_t i = 0; i < 61; ++i) {
      tiles.vertices_m.emplace_back(-15 + 0.5 * i, -15 + 0.5 * j, -10);
      const std::uint32_t k = 61 * j + i;
      if (i == 60 || j == 60) continue;
      tiles.triangles.push_back({k, k + 1, k + 61});
      tiles.triangles.push_back({k + 1, k + 62, k + 61});
    }
  }
  for (const World& world : {terrain_world(flat), solid_world(tiles, Pose{})}) {
    RigidBodyWorld bodies(world, kStep_s);
    BodyState state = at(-3, -2, -10 + 0.3005);
    state.velocity_body << 1.0, 0.7, 0, 0, 0, 0;
    bodies.add_body({"body", craft, CollisionShape::kHull, 0, 0}, state);
    for (int k = 0; k < 1000; ++k) bodies.step(EvenWater{}, 0);
    EXPECT_LT((bodies.state(0).velocity_body - state.velocity_body).norm(), 1e-3);
  }
}

TEST(Contact, EqualStatesHaveEqualFutures) {
  const auto craft = box_craft(sinking_box(500));
  const World world = terrain_world(rough);
  const BodySpec spec{"body", craft, CollisionShape::kHull, 0.6, 0.1};
  RigidBodyWorld bodies(world, kStep_s), other(world, kStep_s);
  bodies.add_body(spec, at(0.4, 0.3, -9.2));
  other.add_body(spec, at(7, 5, -9.4));
  for (int k = 0; k < 150; ++k) {
    bodies.step(EvenWater{}, 0);
    other.step(EvenWater{}, 0);
  }
  other.set_state(0, bodies.state(0));  // placed there, with a different history
  for (int k = 0; k < 500; ++k) {
    bodies.step(EvenWater{}, 0);
    other.step(EvenWater{}, 0);
    ASSERT_EQ(bodies.state(0).velocity_body, other.state(0).velocity_body) << "step " << k;
  }
}

TEST(Contact, PiecesLeaveTheHollowsThatAHullFills) {
  // A portal made of three boxes straddles a post that its convex hull would hit.
  const auto moved = [](TriangleMesh mesh, const Eigen::Vector3d& by) {
    for (auto& v : mesh.vertices_m) v += by;
    return mesh.vertices_m;
  };
  const std::vector<ConvexPiece> portal = {moved(testing::box(0.4, 0.1, 0.6), {0, 0.35, 0}),
                                           moved(testing::box(0.4, 0.1, 0.6), {0, -0.35, 0}),
                                           moved(testing::box(0.4, 0.8, 0.1), {0, 0, 0.25})};
  Pose pose;
  pose.position_m = {3, 0, -20};
  const World world = solid_world(testing::box(0.2, 0.3, 0.2), pose);
  const auto passes = [&](CollisionShape shape) {
    RigidBodyWorld bodies(world, kStep_s);
    BodyState state = at(0, 0, -20);
    state.velocity_body(0) = 1;
    BodySpec spec{"body", box_craft(box_parameters(1000)), shape, 0, 0};
    spec.collision_pieces_body_m = portal;
    bodies.add_body(spec, state);
    for (int k = 0; k < 1200; ++k) bodies.step(EvenWater{}, 0);
    return bodies.state(0).world_from_body.position_m.x() > 4;
  };
  EXPECT_TRUE(passes(CollisionShape::kPieces));
  EXPECT_FALSE(passes(CollisionShape::kHull));
}

TEST(Contact, ABodyWithTenTimesItsMassAddedIsStableInACollision) {
  CraftParameters light = box_parameters(1000), heavy = box_parameters(1000);
  light.added_mass.diagonal() << 100, 100, 100, 10, 10, 10;
  for (Eigen::Index axis = 0; axis < 6; ++axis) {
    heavy.added_mass.setZero();
    heavy.added_mass(axis, axis) = 10 * (axis < 3 ? heavy.mass_kg : heavy.inertia_kg_m2(axis - 3, axis - 3));
    const auto hit = box_craft(heavy), hitting = box_craft(light);
    RigidBodyWorld bodies(World{}, kStep_s);
    BodyState coming = at(-2.5, 0.25, -30.2);
    coming.velocity_body << 1.5, 0, 0, 0, 0, 0.2;
    bodies.add_body({"hit", hit, CollisionShape::kHull, 0.3, 0.2}, at(0, 0, -30));
    bodies.add_body({"hitting", hitting, CollisionShape::kHull, 0.3, 0.2}, coming);
    const double start = hitting->kinetic_energy_j(coming);
    bool touched = false;
    for (int k = 0; k < 2000; ++k) {
      bodies.step(EvenWater{}, 0);
      touched |= bodies.in_contact(0);
      const double now = hit->kinetic_energy_j(bodies.state(0)) + hitting->kinetic_energy_j(bodies.state(1));
      ASSERT_LT(now, start * (1 + 2e-3)) << "axis " << axis << " step " << k;
    }
    EXPECT_TRUE(touched);
  }
}

}  // namespace
}  // namespace uwsim
