#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "dynamics/bodies.h"

// Laws of contact for bodies that turn or move far within a step.
namespace uwsim {
namespace {

constexpr double kPlate_m = 0.05;  // thickness

std::shared_ptr<const Craft> cube(double side_m) {
  const TriangleMesh mesh = testing::box(side_m, side_m, side_m);
  return craft_of(solid_of(mesh, 1000), mesh);
}

/// A plate whose front face is the plane x = 0.
World plate_world() {
  return solid_world(testing::moved(testing::box(kPlate_m, 40, 40), {kPlate_m / 2, 0, -30}), "plate");
}

/// A 4 cm cube, thrown at the plate at 20 m/s, at up to 45 degrees from the plate's normal.
BodyState thrown(std::mt19937_64& draws) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> share(-1, 1);
  BodyState state = at(-0.3 + 0.1 * share(draws), 0, -30);
  Eigen::Vector4d turn;
  for (double& each : turn) each = normal(draws);
  state.world_from_body.orientation = Eigen::Quaterniond(turn.normalized());
  const Eigen::Vector3d velocity = 20 * Eigen::Vector3d(1, share(draws), share(draws)).normalized();
  state.velocity_body.head<3>() = state.world_from_body.orientation.conjugate() * velocity;
  return state;
}

TEST(FastBodies, ASmallCubeNeverGoesThroughAPlate) {
  const World world = plate_world();
  const auto craft = cube(0.04);
  std::mt19937_64 draws(31);
  for (int throw_number = 0; throw_number < 1000; ++throw_number) {
    RigidBodyWorld bodies(world, kStep_s);
    bodies.add_body(body_of(craft, 0.5), thrown(draws));
    bool touched = false;
    for (int k = 0; k < 60; ++k) {
      bodies.step(EvenWater{}, 0);
      touched |= bodies.in_contact(0);
      ASSERT_LT(place_m(bodies).x(), -0.018) << throw_number << " step " << k;
    }
    ASSERT_TRUE(touched) << throw_number;
  }
}

TEST(FastBodies, ASlowBodyElsewhereTakesNoPartInThePartsOfAStep) {
  const auto craft = cube(0.04);
  std::mt19937_64 draws(31);
  const BodyState fast = thrown(draws);
  BodyState slow = at(-8, 3, -30);
  slow.velocity_body << 0.5, 0.2, 0, 0.3, -0.4, 2;
  const auto flown = [&](bool with_fast) {
    RigidBodyWorld bodies(plate_world(), kStep_s);
    bodies.add_body(body_of(craft, 0.5), slow);
    if (with_fast) bodies.add_body(body_of(craft, 0.5), fast);
    run(bodies, 60);
    return bodies.state(0);
  };
  const BodyState alone = flown(false), both = flown(true);
  EXPECT_EQ(alone.world_from_body.position_m, both.world_from_body.position_m);
  EXPECT_EQ(alone.velocity_body, both.velocity_body);
}

}  // namespace
}  // namespace uwsim
