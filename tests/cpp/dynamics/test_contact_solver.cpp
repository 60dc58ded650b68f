#include "uwsim/dynamics/contact_solver.h"

#include <gtest/gtest.h>

namespace uwsim {
namespace {

/// A body whose added mass makes it ten times heavier sideways than ahead.
ContactBody heavy_sideways(const Vector6d& velocity) {
  Matrix6d mass = Matrix6d::Zero();
  mass.diagonal() << 100, 1000, 500, 5, 20, 30;
  mass(1, 5) = mass(5, 1) = 40;  // centre of mass ahead of the origin
  ContactBody body;
  body.velocity_body = body.start_velocity_body = velocity;
  body.inverse_mass = mass.inverse();
  return body;
}

double kinetic_energy(const ContactBody& body) {
  return 0.5 * body.velocity_body.dot(body.inverse_mass.inverse() * body.velocity_body);
}

Vector6d point_row(const Eigen::Vector3d& point, const Eigen::Vector3d& direction) {
  Vector6d j;
  j << direction, point.cross(direction);
  return j;
}

TEST(ContactSolver, TheImpulseFollowsFromTheWholeMassMatrix) {
  Vector6d velocity;
  velocity << 1.5, -0.8, 0.3, 0, 0.1, 0.4;
  for (const Eigen::Vector3d& normal : {Eigen::Vector3d(-1, 0, 0), Eigen::Vector3d(-1, 1, 0.2).normalized().eval()}) {
    for (const double restitution : {0.0, 0.5, 1.0}) {
      const Eigen::Vector3d point(0.5, 0.2, -0.1);
      ContactBody body = heavy_sideways(velocity);
      const double energy = kinetic_energy(body);
      const Vector6d j = point_row(point, normal);
      const double approach = j.dot(velocity);
      ASSERT_LT(approach, 0);
      const double expected = -(1 + restitution) * approach / j.dot(body.inverse_mass * j);
      const Contact contact{.a = 0, .point_world_m = point, .normal_world = normal, .restitution = restitution};
      ContactSolver().solve({&body, 1}, {&contact, 1}, 0.005);
      EXPECT_NEAR(body.impulse_body.head<3>().norm(), expected, 1e-9 * expected);
      EXPECT_NEAR(j.dot(body.velocity_body), -restitution * approach, 1e-12);
      EXPECT_LE(kinetic_energy(body), energy * (1 + 1e-12));
    }
  }
}

TEST(ContactSolver, FrictionStaysWithinCoulombsConeAndStopsASlowSlide) {
  const Contact contact{
      .a = 0, .point_world_m = {0, 0, -0.3}, .normal_world = {0, 0, 1}, .friction = 0.3, .restitution = 0};
  Vector6d fast = Vector6d::Zero(), slow = Vector6d::Zero();
  fast << 5, 0, -0.5, 0, 0, 0;
  slow << 0.001, 0, -0.5, 0, 0, 0;
  ContactBody sliding = heavy_sideways(fast), sticking = heavy_sideways(slow);
  ContactSolver().solve({&sliding, 1}, {&contact, 1}, 0.005);
  EXPECT_LE(sliding.impulse_body.head<2>().norm(), 0.3 * sliding.impulse_body(2) * (1 + 1e-9));
  EXPECT_GT(sliding.velocity_body(0), 0);
  ContactSolver().solve({&sticking, 1}, {&contact, 1}, 0.005);
  EXPECT_NEAR(point_row(contact.point_world_m, Eigen::Vector3d::UnitX()).dot(sticking.velocity_body), 0, 1e-9);
}

TEST(ContactSolver, AGapMayCloseButNotBeCrossedInOneStep) {
  Vector6d down = Vector6d::Zero();
  down(2) = -1;
  ContactBody body = heavy_sideways(down);
  const Contact contact{.a = 0, .point_world_m = {0, 0, 0}, .normal_world = {0, 0, 1}, .gap_m = 0.002};
  ContactSolver().solve({&body, 1}, {&contact, 1}, 0.005);
  EXPECT_GE(body.velocity_body(2), -0.002 / 0.005 - 1e-9);
}

TEST(ContactSolver, AnOverlapIsSeparatedWithoutAddingVelocity) {
  ContactBody body = heavy_sideways(Vector6d::Zero());
  const Contact contact{.a = 0, .point_world_m = {0, 0, 0}, .normal_world = {0, 0, 1}, .gap_m = -0.02};
  ContactSolver().solve({&body, 1}, {&contact, 1}, 0.005);
  EXPECT_EQ(body.velocity_body.norm(), 0);
  EXPECT_GT(body.push_body(2), 0);
}

}  // namespace
}  // namespace uwsim
