#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "dynamics/bodies.h"
#include "meshes.h"
#include "uwsim/core/check.h"
#include "uwsim/dynamics/rigid_body_world.h"

namespace uwsim::tether_contact_tests {  // other files have some of these names, too
namespace {

constexpr double kGravity = 9.80665;

EvenWater vacuum(double gravity) {
  EvenWater water;
  water.density_kg_m3 = 1e-12;
  water.gravity_m_s2 = gravity;
  return water;
}

TriangleMesh moved(TriangleMesh mesh, const Eigen::Vector3d& by) {
  for (Eigen::Vector3d& vertex : mesh.vertices_m) vertex += by;
  return mesh;
}

/// A bar along y about the origin.
TriangleMesh bar(double radius, double length, std::uint32_t sides) {
  TriangleMesh mesh;
  for (std::uint32_t k = 0; k < sides; ++k) {
    const double angle = 2 * std::numbers::pi * k / sides;
    for (const double y : {-length / 2, length / 2})
      mesh.vertices_m.emplace_back(radius * std::sin(angle), y, radius * std::cos(angle));
  }
  for (std::uint32_t k = 0; k < sides; ++k) {
    const std::uint32_t next = (k + 1) % sides;
    mesh.triangles.push_back({2 * k, 2 * next, 2 * k + 1});
    mesh.triangles.push_back({2 * next, 2 * next + 1, 2 * k + 1});
    if (k > 0 && k + 1 < sides) {
      mesh.triangles.push_back({0, 2 * k + 2, 2 * k});
      mesh.triangles.push_back({1, 2 * k + 1, 2 * k + 3});
    }
  }
  return mesh;
}

BodySpec block(const std::string& name, double mass_kg, double side = 0.2) {
  CraftParameters p;
  p.mass_kg = mass_kg;
  p.inertia_kg_m2 = mass_kg * Eigen::Vector3d(0.007, 0.007, 0.007).asDiagonal();
  p.linear_damping.diagonal() << 5, 5, 5, 1, 1, 1;
  return {name, std::make_shared<const Craft>(p, BuoyantHull(testing::box(side, side, side)))};
}

TetherSpec between(const Eigen::Vector3d& first, const Eigen::Vector3d& second, double length_m, std::uint64_t n) {
  TetherSpec spec;
  spec.first.point_m = first;
  spec.second.point_m = second;
  spec.length_m = length_m;
  spec.elements = n;
  spec.diameter_m = 0.02;
  spec.mass_kg_m = 0.05;
  spec.axial_stiffness_n = 1e5;
  spec.bending_stiffness_n_m2 = 0;
  return spec;
}

class Rig {
 public:
  explicit Rig(const World& world = {}, double step_s = kStep_s) : step_s(step_s), bodies(world, step_s) {}
  void step(const WaterField& water, int count = 1) {
    for (int k = 0; k < count; ++k, ++steps) bodies.step(water, steps * step_s);
  }
  Tether& add(const TetherSpec& spec, const WaterField& water) {
    return bodies.tether(bodies.add_tether(spec, water, 0));
  }
  double step_s;
  RigidBodyWorld bodies;
  int steps = 0;
};

/// A weight that hangs over a bar from a winch.
struct OverABar {
  explicit OverABar(double friction, double step_s = kStep_s) : rig(world(), step_s) {
    rig.bodies.add_body(block("weight", 10), at(3, 0, 1));
    spec.second.body = 0;
    spec.second.point_m = {0, 0, 0.1};
    spec.friction = friction;
    spec.fastest_m_s = 1;
    tether = &rig.add(spec, vacuum(0));
  }
  static World world() {
    World made;
    made.add_solid("bar", bar(0.5, 4, 48));
    return made;
  }
  double turned() const {
    const std::size_t n = tether->elements();
    const Eigen::Vector3d first = tether->position_m(1) - tether->position_m(0);
    const Eigen::Vector3d last = tether->position_m(n) - tether->position_m(n - 1);
    return std::acos(first.normalized().dot(last.normalized()));
  }
  double winch_n() const { return tether->tension_n(1); }
  double weight_n() const { return tether->tension_n(tether->elements() - 1); }

  TetherSpec spec = between({-3, 0, 0.8}, {3, 0, 0.8}, 6.05, 60);
  Rig rig;
  Tether* tether;
};

TEST(TetherContact, FollowsTheCapstanEquation) {
  for (const double friction : {0.0, 0.2, 0.4}) {
    OverABar over(friction);
    const EvenWater water = vacuum(kGravity);
    over.rig.step(water, 4000);
    over.tether->command({WinchCommand::Mode::kRate, -0.02});
    over.rig.step(water, 2000);
    double ratio = 0, turned = 0;
    for (int k = 0; k < 200; ++k) {
      over.rig.step(water, 10);
      ratio += over.winch_n() / over.weight_n() / 200;
      turned += over.turned() / 200;
    }
    // Euler (1769): T2 = T1 exp(mu theta).
    EXPECT_GT(turned, 1.4);
    EXPECT_NEAR(ratio, std::exp(friction * turned), 0.03 * std::exp(friction * turned)) << friction;
    double deepest = 1;
    for (std::size_t i = 0; i < over.tether->elements(); ++i) {
      const Eigen::Vector3d from = over.tether->position_m(i), way = over.tether->position_m(i + 1) - from;
      const double share = std::clamp(-from.dot(way) / way.squaredNorm(), 0.0, 1.0);
      deepest = std::min(deepest, std::hypot((from + share * way).x(), (from + share * way).z()));
    }
    EXPECT_GT(deepest, 0.5 * std::cos(std::numbers::pi / 48) + 0.005) << "it overlaps by less than half of its radius";
  }
}

TEST(TetherContact, HangsOverABarAndStays) {
  OverABar over(0.5);
  const EvenWater water = vacuum(kGravity);
  over.rig.step(water, 6000);
  const Eigen::Vector3d before = over.tether->position_m(30);
  const double lowest = over.rig.bodies.state(0).world_from_body.position_m.z();
  over.rig.step(water, 4000);
  EXPECT_LT((over.tether->position_m(30) - before).norm(), 20 * 1e-4) << "no faster than friction's creep";
  EXPECT_NEAR(over.rig.bodies.state(0).world_from_body.position_m.z(), lowest, 20 * 1e-4);
  const double most = std::exp(0.5 * over.turned());
  EXPECT_GT(over.winch_n(), over.weight_n() / most);
  EXPECT_LT(over.winch_n(), over.weight_n() * most);
}

TEST(TetherContact, NeverGainsEnergyOnABox) {
  for (const double ea : {1e3, 1e5, 1e7}) {
    World world;
    world.add_solid("box", moved(testing::box(2, 2, 1), {0, 0, -1}));
    TetherSpec spec = between({-0.7, 0.1, 0.1}, {0.7, 0, 0.2}, 1.5, 20);
    spec.axial_stiffness_n = ea;
    Rig rig(world);
    Tether& tether = rig.add(spec, vacuum(kGravity));
    tether.cut(0);
    const auto energy = [&] {
      double sum = 0;
      for (std::size_t i = 0; i <= tether.elements(); ++i)
        sum += tether.mass_kg(i) * (0.5 * tether.velocity_m_s(i).squaredNorm() + kGravity * tether.position_m(i).z());
      for (std::size_t i = 1; i < tether.elements(); ++i) {
        const double rest = tether.rest_m(i);
        const double stretch = std::max(0.0, (tether.position_m(i + 1) - tether.position_m(i)).norm() - rest);
        sum += 0.5 * ea / rest * stretch * stretch;
      }
      for (const TetherContact& contact : tether.contacts())
        sum += 0.5 * contact.force_n * contact.force_n / contact.stiffness;
      return sum;
    };
    const double scale = 1.5 * 0.05 * kGravity;  // its weight, times a metre
    double before = energy();
    for (int k = 0; k < 1200; ++k) {
      rig.step(vacuum(kGravity));
      const double now = energy();
      ASSERT_LE(now, before + 1e-4 * scale) << "EA " << ea << ", step " << k;
      before = std::min(before, now);
      for (std::size_t i = 1; i <= tether.elements(); ++i) {
        const Eigen::Vector3d p = tether.position_m(i);
        const bool is_over = p.head<2>().cwiseAbs().maxCoeff() < 0.9;
        ASSERT_TRUE(!is_over || p.z() > -0.5 + 0.005) << "step " << k << ", node " << i;
      }
    }
  }
}

TEST(TetherContact, PullsAVehicleRoundAPile) {
  World world;
  world.add_solid("pile", bar(0.3, 6, 32));
  Rig rig(world);
  rig.bodies.add_body(block("rov", 12), at(2, 0, 1.2));
  TetherSpec spec = between({-2, 0, 0.6}, {0, 0, 0}, 4.1, 40);
  spec.second.body = 0;
  spec.friction = 0.1;
  Tether& tether = rig.add(spec, vacuum(0));
  Loads down;
  down.world << 0, 0, -40, 0, 0, 0;
  rig.bodies.apply(0, down);
  rig.step(vacuum(0), 4000);
  const Eigen::Vector3d at_body = rig.bodies.state(0).world_from_body.position_m, pull = tether.end_force_n(1);
  // It hangs below the pile, and is pulled towards that, not towards the anchor.
  EXPECT_LT(at_body.z(), -0.5);
  EXPECT_NEAR(std::abs(at_body.x()), 0.31, 0.1);
  EXPECT_NEAR(pull.z(), 40, 4);
  EXPECT_LT(std::abs(pull.x()), 6);
}

TEST(TetherContact, StopsAHullAndTakesItsMomentum) {
  for (const double step_s : {0.002, 0.02}) {
    Rig rig({}, step_s);
    BodyState state = at(0.05, 0, -0.5);
    state.velocity_body << 0, 0, 1, 0, 0, 0;
    rig.bodies.add_body(block("rov", 12), state);
    TetherSpec spec = between({-2, 0, 0}, {2, 0, 0}, 4.02, 40);
    Tether& tether = rig.add(spec, vacuum(0));
    double before = 0.5 * 12;
    for (int k = 0; k < 3 / step_s; ++k) {
      rig.step(vacuum(0));
      const BodyState& now = rig.bodies.state(0);
      const double speed = now.linear_body_m_s().norm();
      ASSERT_LT(0.5 * 12 * speed * speed, before * 1.01);
      ASSERT_LT(now.world_from_body.position_m.z(), 0.6);
    }
    EXPECT_LT(rig.bodies.state(0).world_from_body.direction(rig.bodies.state(0).linear_body_m_s()).z(), 0.1)
        << "it is thrown back or stopped";
    EXPECT_FALSE(tether.broken());
  }
}

TEST(TetherContact, IsRefusedThroughASolid) {
  World world;
  world.add_solid("wall", testing::box(0.2, 20, 20));
  Rig rig(world);
  try {
    rig.add(between({-2, 0, 0}, {2, 0, 0}, 4.5, 20), vacuum(0));
    FAIL();
  } catch (const InvalidValue& error) {
    EXPECT_STREQ(error.what(),
                 "tether = 4.5 m from [-2 0 0] m: passes through 'wall' wherever it is laid: move an end, or use "
                 "another length");
  }
}

}  // namespace
}  // namespace uwsim::tether_contact_tests
