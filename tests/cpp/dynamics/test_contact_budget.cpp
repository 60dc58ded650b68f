#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "dynamics/bodies.h"
#include "meshes.h"
#include "uwsim/core/check.h"
#include "uwsim/dynamics/contact_budget.h"
#include "uwsim/dynamics/rigid_body_world.h"

// Law: a step's search for contacts is limited by the number of feature tests, not by time. Scenes in the wrong unit
// are refused with an error that states the values; scenes that are large by nature are not refused.
namespace uwsim {
namespace {

std::shared_ptr<const Craft> sinking_craft(const TriangleMesh& mesh) {
  const SolidProperties solid = solid_properties(mesh);
  CraftParameters p;
  p.mass_kg = 1100 * solid.volume_m3;
  p.inertia_kg_m2 = 1100 * solid.inertia_per_density_m5;
  return std::make_shared<const Craft>(p, BuoyantHull(mesh));
}

/// A bed about 10 m deep on which every node is a peak or a hollow.
World rough_bed(std::size_t nodes, double spacing_m) {
  std::vector<float> heights;
  for (std::size_t j = 0; j < nodes; ++j) {
    for (std::size_t i = 0; i < nodes; ++i) heights.push_back((i * 7 + j * 5) % 3 == 0 ? -9.9F : -10.0F);
  }
  const double edge = -0.5 * static_cast<double>(nodes - 1) * spacing_m;
  World world;
  world.set_terrain(Heightfield(heights, nodes, nodes, spacing_m, {edge, edge}));
  return world;
}

/// The message with which a step of a box with these edge lengths is refused; empty if it is not refused.
std::string refusal(const World& world, double x, double y, double z, double height_m) {
  RigidBodyWorld bodies(world, kStep_s);
  BodyState start;
  start.world_from_body.position_m = {0.013, 0.017, height_m};
  bodies.add_body({"rov", sinking_craft(testing::box(x, y, z))}, start);
  try {
    for (int k = 0; k < 3; ++k) bodies.step(EvenWater{}, 0);
  } catch (const InvalidValue& error) {
    EXPECT_EQ(bodies.state(0).world_from_body.position_m, start.world_from_body.position_m) << "no body has moved";
    return error.what();
  }
  return {};
}

TEST(ContactBudget, AHullInMillimetresIsRefusedWithItsNumbers) {
  const std::string message = refusal(rough_bed(601, 0.2), 1200, 800, 700, -5);
  EXPECT_NE(message.find("vehicle 'rov', contact search"), std::string::npos) << message;
  EXPECT_NE(message.find("1200 x 800 x 700 m"), std::string::npos) << message;
  EXPECT_NE(message.find("is its mesh in millimetres?"), std::string::npos) << message;
}

TEST(ContactBudget, ASmallHullAmongTooManyTrianglesIsRefusedForThem) {
  const std::string message = refusal(rough_bed(801, 0.001), 1.2, 0.9, 0.7, -9.6);
  EXPECT_NE(message.find("use a coarser mesh"), std::string::npos) << message;
  EXPECT_EQ(message.find("millimetres"), std::string::npos) << message;
}

TEST(ContactBudget, AVehicleOnAFineBedAndAShipAreNot) {
  EXPECT_EQ(refusal(rough_bed(201, 0.02), 1.2, 0.8, 0.7, -9.56), "");  // 5,000 triangles, on the peaks
  EXPECT_EQ(refusal(rough_bed(701, 0.5), 300, 40, 20, 0.1005), "");    // 100,000 triangles
}

TEST(ContactBudget, AVehicleBesideAShipOf300MetresIsNot) {
  TriangleMesh ship = testing::sphere(1, 300);  // 360,000 triangles
  for (Eigen::Vector3d& v : ship.vertices_m) v = v.cwiseProduct(Eigen::Vector3d(150, 20, 10));
  World world;
  world.add_solid("ship", std::move(ship));
  EXPECT_EQ(refusal(world, 1.2, 0.8, 0.7, 10.4), "");
}

TEST(ContactBudget, BeginsAgainWithEachBody) {
  ContactBudget budget;
  budget.begin(0, {1, 1, 1});
  budget.spend(ContactBudget::kMostTests);
  EXPECT_THROW(budget.spend(1), ContactBudgetExceeded);
  budget.begin(1, {1, 1, 1});
  EXPECT_NO_THROW(budget.spend(ContactBudget::kMostTests));
}

}  // namespace
}  // namespace uwsim
