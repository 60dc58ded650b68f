#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "dynamics/bodies.h"
#include "uwsim/dynamics/contact_finder.h"

// Laws of contact for RigidBodyWorld, including shapes, contact finder, solver and integrator.
namespace uwsim {
namespace {

World terrain_world(double (*height_m)(double x_m, double y_m)) { return bed_world(121, 0.5, height_m); }

double flat(double, double) { return -10; }
double gentle(double x, double) { return -10 + 0.25 * x; }
double rough(double x, double y) { return -10 + 0.3 * std::sin(1.3 * x) * std::cos(0.9 * y) + 0.1 * std::sin(4 * y); }

double mechanical_energy(const Craft& craft, const BodyState& state) {
  const double weight = (craft.parameters().mass_kg - 1000 * craft.hull().solid().volume_m3) * kGravity;
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
  bodies.add_body(body_of(std::move(craft)), start);
  run(bodies, settle);
  const Eigen::Vector3d place = place_m(bodies);
  double sum = 0;
  for (int k = 0; k < 400; ++k) {
    bodies.step(EvenWater{}, 0);
    sum += bodies.state(0).velocity_body.squaredNorm();
  }
  return {std::sqrt(sum / 400), (place_m(bodies) - place).norm(), bodies.state(0)};
}

std::shared_ptr<const Craft> sinking_box(double added_mass = 500) {
  CraftParameters p = brick_parameters(2000);
  p.added_mass.diagonal() << added_mass, added_mass, added_mass, added_mass / 10, added_mass / 6, added_mass / 5;
  p.linear_damping.diagonal() << 50, 50, 50, 20, 20, 20;
  return craft_of(p);
}

TEST(Contact, ABodyRestsWithoutJitterWithinAMillimetreOfTheBed) {
  for (const double added : {0.0, 11520.0}) {  // none, and ten times the rigid-body mass
    const Rest on_flat = rest(terrain_world(flat), sinking_box(added), at(0.1, 0.2, -9.5), 2000);
    EXPECT_LT(on_flat.rms_speed, 1e-4) << added;
    EXPECT_NEAR(on_flat.end.world_from_body.position_m.z(), -10 + 0.3 + 0.5 * kRestGap_m, 0.6 * kRestGap_m);
  }
}

TEST(Contact, ABodyRestsOnASolidsMesh) {
  const World world = solid_world(testing::moved(testing::box(3, 3, 1), {0, 0, -12}));
  const Rest on_box = rest(world, sinking_box(), at(0, 0, -11), 2000);
  EXPECT_LT(on_box.rms_speed, 1e-4);
  EXPECT_NEAR(on_box.end.world_from_body.position_m.z(), -11.5 + 0.3, 1.2 * kRestGap_m);
}

TEST(Contact, ABodyThatIsHeldRestsToTheLastBit) {
  BodyState tilted = at(0, 0, -9.6);
  tilted.world_from_body.orientation = Eigen::AngleAxisd(-std::atan(0.25), Eigen::Vector3d::UnitY());
  const Rest ends[] = {rest(terrain_world(flat), sinking_box(), at(0.1, 0.2, -9.5), 4000),
                       rest(terrain_world(gentle), sinking_box(), tilted, 4000),
                       rest(terrain_world(rough), sinking_box(), at(0.4, 0.3, -9), 8000)};
  for (const Rest& end : ends) {
    EXPECT_EQ(end.rms_speed, 0);
    EXPECT_EQ(end.drift_m, 0);
  }
}

/// It is pulled along x by a force that increases to twice what friction can hold.
TEST(Contact, ABodyAtRestMovesAsSoonAsFrictionIsExceeded) {
  const auto craft = sinking_box();
  RigidBodyWorld bodies(terrain_world(flat), kStep_s);
  bodies.add_body(body_of(craft), at(0.1, 0.2, -9.69));
  run(bodies, 2000);
  const double held_n = 0.6 * (craft->parameters().mass_kg - 1000 * craft->hull().solid().volume_m3) * kGravity;
  std::vector<double> places_m;
  for (int k = 0; k < 400; ++k) {
    bodies.set_wrench(0, ahead(2 * held_n * (k / 4 * 4) / 400));  // constant for four steps
    bodies.step(EvenWater{}, 0);
    places_m.push_back(place_m(bodies).x());
  }
  for (std::size_t k = 0; k < 200; ++k) EXPECT_EQ(places_m[k], places_m[0]) << k;
  EXPECT_GT(places_m[212], places_m[0]);
  EXPECT_GT(places_m[399] - places_m[0], 0.05);
}

TEST(Contact, TheImpulseOfAStepIsThatOfTheFullMassMatrix) {
  CraftParameters p = brick_parameters(1000);
  p.added_mass.diagonal() << 300, 2000, 4000, 150, 250, 500;
  const auto craft = craft_of(p);
  Matrix6d mass = p.added_mass;
  mass.topLeftCorner<3, 3>() += p.mass_kg * Eigen::Matrix3d::Identity();
  mass.bottomRightCorner<3, 3>() += p.inertia_kg_m2;
  for (const double wall_yaw : {0.0, 0.3}) {  // perpendicular, and oblique, so that a corner hits the wall
    for (const double restitution : {0.0, 0.5, 1.0}) {
      const Pose pose{{3, 0, -30}, Eigen::Quaterniond(Eigen::AngleAxisd(wall_yaw, Eigen::Vector3d::UnitZ()))};
      RigidBodyWorld bodies(solid_world(testing::placed(testing::box(0.4, 40, 40), pose)), kStep_s);
      BodyState state = at(0, 0, -30);
      // hits with an edge instead of a face
      state.world_from_body.orientation = Eigen::AngleAxisd(0.2, Eigen::Vector3d(0, 1, 0));
      state.velocity_body << state.world_from_body.orientation.conjugate() * Eigen::Vector3d(1.0, 0, 0), 0, 0, 0;
      bodies.add_body(body_of(craft, 0, restitution), state);
      BodyState before = state;
      while (!bodies.in_contact(0) && place_m(bodies).x() < 4) {
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
  CraftParameters p = brick_parameters(1500);
  p.added_mass.diagonal() << 300, 3000, 8000, 100, 250, 400;
  const auto craft = craft_of(p);
  for (const double restitution : {0.0, 0.5}) {
    for (const double friction : {0.0, 0.8}) {
      RigidBodyWorld bodies(terrain_world(rough), kStep_s);
      BodyState state = at(0.3, -0.2, -8);
      state.velocity_body << 1.5, 0.4, -1, 0.6, -0.5, 0.8;
      bodies.add_body(body_of(craft, friction, restitution), state);
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
  CraftParameters p = brick_parameters(1000);
  p.added_mass.diagonal() << 100, 100, 100, 10, 10, 10;
  const auto craft = craft_of(p);
  for (const double speed : {1.6, 5.0, 12.0}) {
    RigidBodyWorld bodies(solid_world(testing::moved(testing::box(0.004, 6, 6), {5, 0, -20})), kStep_s);
    BodyState state = at(0, 0, -20);
    state.velocity_body(0) = speed;
    bodies.add_body(body_of(craft, 0, 0), state);
    for (int k = 0; k < 2000; ++k) {
      bodies.step(EvenWater{}, 0);
      ASSERT_LT(place_m(bodies).x(), 5 - 0.002 - 0.6) << speed << " step " << k;
    }

    RigidBodyWorld over_ground(terrain_world(rough), kStep_s);
    BodyState diving = at(0, 0, -6);
    diving.world_from_body.orientation = Eigen::AngleAxisd(0.9, Eigen::Vector3d(0.3, 1, 0).normalized());
    diving.velocity_body(0) = speed;
    over_ground.add_body(body_of(craft, 0.5), diving);
    for (int k = 0; k < 2000; ++k) {
      over_ground.step(EvenWater{}, 0);
      const Eigen::Vector3d place = place_m(over_ground);
      if (place.head<2>().cwiseAbs().maxCoeff() > 28) break;
      ASSERT_GT(place.z(), rough(place.x(), place.y()) + 0.2) << speed << " step " << k;
    }
  }
}

TEST(Contact, ABodyPlacedInsideTheGroundIsPushedOutSlowly) {
  for (const double depth_m : {0.2, 3.0}) {
    RigidBodyWorld bodies(terrain_world(rough), kStep_s);
    bodies.add_body(body_of(sinking_box()), at(0.4, 0.3, rough(0.4, 0.3) - depth_m));
    double fastest = 0;
    for (int k = 0; k < 1500; ++k) {
      bodies.step(EvenWater{}, 0);
      fastest = std::max(fastest, bodies.state(0).velocity_body.norm());
    }
    const Eigen::Vector3d place = place_m(bodies);
    EXPECT_GT(place.z(), rough(place.x(), place.y()) + 0.2);
    EXPECT_LT(fastest, 1.5);
  }
}

TEST(Contact, PiecesLeaveTheHollowsThatAHullFills) {
  // A portal made of three boxes straddles a post that its convex hull would hit.
  const std::vector<ConvexPiece> portal = {testing::moved(testing::box(0.4, 0.1, 0.6), {0, 0.35, 0}).vertices_m,
                                           testing::moved(testing::box(0.4, 0.1, 0.6), {0, -0.35, 0}).vertices_m,
                                           testing::moved(testing::box(0.4, 0.8, 0.1), {0, 0, 0.25}).vertices_m};
  const World world = solid_world(testing::moved(testing::box(0.2, 0.3, 0.2), {3, 0, -20}));
  const auto passes = [&](CollisionShape shape) {
    RigidBodyWorld bodies(world, kStep_s);
    BodyState state = at(0, 0, -20);
    state.velocity_body(0) = 1;
    BodySpec spec = body_of(craft_of(brick_parameters(1000)), 0, 0);
    spec.shape = shape;
    spec.collision_pieces_body_m = portal;
    bodies.add_body(spec, state);
    run(bodies, 1200);
    return place_m(bodies).x() > 4;
  };
  EXPECT_TRUE(passes(CollisionShape::kPieces));
  EXPECT_FALSE(passes(CollisionShape::kHull));
}

TEST(Contact, ABodyWithTenTimesItsMassAddedIsStableInACollision) {
  CraftParameters light = brick_parameters(1000), heavy = light;
  light.added_mass.diagonal() << 100, 100, 100, 10, 10, 10;
  for (Eigen::Index axis = 0; axis < 6; ++axis) {
    heavy.added_mass.setZero();
    heavy.added_mass(axis, axis) = 10 * (axis < 3 ? heavy.mass_kg : heavy.inertia_kg_m2(axis - 3, axis - 3));
    const auto hit = craft_of(heavy), hitting = craft_of(light);
    RigidBodyWorld bodies(World{}, kStep_s);
    BodyState coming = at(-2.5, 0.25, -30.2);
    coming.velocity_body << 1.5, 0, 0, 0, 0, 0.2;
    bodies.add_body(body_of(hit, 0.3, 0.2), at(0, 0, -30));
    bodies.add_body(body_of(hitting, 0.3, 0.2), coming);
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
