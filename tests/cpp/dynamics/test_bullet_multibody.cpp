#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "dynamics/bodies.h"
#include "uwsim/core/check.h"
#include "uwsim/dynamics/articulated_body.h"

namespace uwsim::multibody_tests {
namespace {

constexpr float kStep_s = 0.01F;

/// Chains and trees of hinges and slides in any direction, on a base that stands.
struct Mechanism {
  std::vector<ArmLink> links;
  std::vector<double> positions, speeds;

  Mechanism(unsigned seed, std::size_t count) {
    std::mt19937 draw(seed);
    std::uniform_real_distribution<double> unit(-1, 1);
    for (std::size_t k = 0; k < count; ++k) {
      ArmLink link;
      link.name = "l" + std::to_string(k);
      link.parent = k == 0 ? ArmLink::kBase : draw() % k;
      link.joint = k % 3 == 2 ? ArmLink::Joint::kSlide : ArmLink::Joint::kHinge;
      link.axis = Eigen::Vector3d(unit(draw), unit(draw), 1).normalized();
      link.parent_from_link = {{unit(draw), unit(draw), unit(draw)},
                               Eigen::Quaterniond(1, unit(draw), unit(draw), unit(draw)).normalized()};
      link.mass_kg = 1.5 + unit(draw);
      link.centre_of_mass_m = {0.3 * unit(draw), 0.3 * unit(draw), 0.3 * unit(draw)};
      link.inertia_kg_m2 = Eigen::Vector3d(0.03, 0.04, 0.05).asDiagonal();
      links.push_back(link);
      positions.push_back(unit(draw));
      speeds.push_back(2 * unit(draw));
    }
  }

  std::vector<double> accelerations() const {
    ArticulatedBody body(links);
    body.place({}, positions, speeds, vacuum(), 0);
    body.fold(std::vector<JointDrive>(links.size()));
    body.unfold(Vector6d::Zero());
    std::vector<double> found;
    for (std::size_t k = 0; k < links.size(); ++k) found.push_back(body.acceleration(k));
    return found;
  }
};

btVector3 vector(const Eigen::Vector3d& v) {
  return {static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()), static_cast<btScalar>(v.z())};
}

/// Returns the change of Bullet's joint speeds in a step, over the step.
std::vector<double> bullets_accelerations(const Mechanism& it) {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broadphase;
  btMultiBodyConstraintSolver solver;
  btMultiBodyDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
  world.setGravity(vector({0, 0, -kGravity}));
  const auto count = static_cast<int>(it.links.size());
  btMultiBody body(count, 1, btVector3(1, 1, 1), true, false);
  for (int k = 0; k < count; ++k) {
    const ArmLink& link = it.links[static_cast<std::size_t>(k)];
    const bool on_base = link.parent == ArmLink::kBase;
    const Eigen::Vector3d carrier_m = on_base ? Eigen::Vector3d::Zero() : it.links[link.parent].centre_of_mass_m;
    const Eigen::Quaterniond turn = link.parent_from_link.orientation.conjugate();
    const btQuaternion link_from_parent(static_cast<btScalar>(turn.x()), static_cast<btScalar>(turn.y()),
                                        static_cast<btScalar>(turn.z()), static_cast<btScalar>(turn.w()));
    const auto mass = static_cast<btScalar>(link.mass_kg);
    const btVector3 inertia = vector(link.inertia_kg_m2.diagonal());
    const btVector3 to_joint = vector(link.parent_from_link.position_m - carrier_m);
    const btVector3 axis = vector(link.axis), to_centre = vector(link.centre_of_mass_m);
    const int parent = on_base ? -1 : static_cast<int>(link.parent);
    if (link.joint == ArmLink::Joint::kHinge) {
      body.setupRevolute(k, mass, inertia, parent, link_from_parent, axis, to_joint, to_centre, true);
    } else {
      body.setupPrismatic(k, mass, inertia, parent, link_from_parent, axis, to_joint, to_centre, true);
    }
  }
  body.finalizeMultiDof();
  body.setLinearDamping(0);
  body.setAngularDamping(0);
  body.setUseGyroTerm(true);
  for (int k = 0; k < count; ++k) {
    body.setJointPos(k, static_cast<btScalar>(it.positions[static_cast<std::size_t>(k)]));
    body.setJointVel(k, static_cast<btScalar>(it.speeds[static_cast<std::size_t>(k)]));
  }
  world.addMultiBody(&body);
  world.stepSimulation(kStep_s, 0);
  std::vector<double> found;
  for (int k = 0; k < count; ++k) {
    const double before = static_cast<float>(it.speeds[static_cast<std::size_t>(k)]);
    found.push_back((static_cast<double>(body.getJointVel(k)) - before) / kStep_s);
  }
  world.removeMultiBody(&body);
  return found;
}

/// Bullet works in single precision.
TEST(ArticulatedBody, AcceleratesAsBulletsMultiBody) {
  double worst = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Mechanism mechanism(seed, 2 + seed % 7);
    const std::vector<double> ours = mechanism.accelerations(), theirs = bullets_accelerations(mechanism);
    const double largest = std::abs(*std::ranges::max_element(ours, {}, [](double a) { return std::abs(a); }));
    for (std::size_t k = 0; k < ours.size(); ++k) worst = std::max(worst, std::abs(ours[k] - theirs[k]) / largest);
  }
  RecordProperty("largest_difference", printed(worst));
  EXPECT_LT(worst, 1e-4);
}

}  // namespace
}  // namespace uwsim::multibody_tests
