#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "dynamics/bodies.h"
#include "refusal.h"
#include "uwsim/dynamics/contact_budget.h"

// Law: a step's search for contacts is limited by the number of feature tests, not by time. Scenes in the wrong unit
// are refused with an error that states the values; scenes that are large by nature are not refused.
namespace uwsim {
namespace {

/// A bed about 10 m deep on which every node is a peak or a hollow.
World rough_bed(int nodes, double spacing_m) {
  return bed_world(nodes, spacing_m, [=](double x_m, double y_m) {
    const double middle = 0.5 * (nodes - 1);
    return std::lround((x_m / spacing_m + middle) * 7 + (y_m / spacing_m + middle) * 5) % 3 == 0 ? -9.9 : -10.0;
  });
}

/// The message with which a step of a box with these edge lengths is refused; empty if it is not refused.
std::string refused(const World& world, double x, double y, double z, double height_m) {
  RigidBodyWorld bodies(world, kStep_s);
  const TriangleMesh mesh = testing::box(x, y, z);
  const BodyState start = at(0.013, 0.017, height_m);
  bodies.add_body({"rov", craft_of(solid_of(mesh, 1100), mesh)}, start);
  const std::string message = refusal([&] { run(bodies, 3); });
  if (!message.empty()) {
    EXPECT_EQ(place_m(bodies), start.world_from_body.position_m) << "no body has moved";
  }
  return message;
}

TEST(ContactBudget, AHullInMillimetresIsRefusedWithItsNumbers) {
  const std::string message = refused(rough_bed(601, 0.2), 1200, 800, 700, -5);
  EXPECT_NE(message.find("vehicle 'rov', contact search"), std::string::npos) << message;
  EXPECT_NE(message.find("1200 x 800 x 700 m"), std::string::npos) << message;
  EXPECT_NE(message.find("is its mesh in millimetres?"), std::string::npos) << message;
}

TEST(ContactBudget, ASmallHullAmongTooManyTrianglesIsRefusedForThem) {
  const std::string message = refused(rough_bed(801, 0.001), 1.2, 0.9, 0.7, -9.6);
  EXPECT_NE(message.find("use a coarser mesh"), std::string::npos) << message;
  EXPECT_EQ(message.find("millimetres"), std::string::npos) << message;
}

TEST(ContactBudget, AVehicleOnAFineBedAndAShipAreNot) {
  EXPECT_EQ(refused(rough_bed(201, 0.02), 1.2, 0.8, 0.7, -9.56), "");  // 5,000 triangles, on the peaks
  EXPECT_EQ(refused(rough_bed(701, 0.5), 300, 40, 20, 0.1005), "");    // 100,000 triangles
}

TEST(ContactBudget, AVehicleBesideAShipOf300MetresIsNot) {
  const World world = solid_world(testing::stretched(testing::sphere(1, 300), {150, 20, 10}));  // 360,000 triangles
  EXPECT_EQ(refused(world, 1.2, 0.8, 0.7, 10.4), "");
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
