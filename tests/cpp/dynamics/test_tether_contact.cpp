#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "dynamics/tethers.h"
#include "refusal.h"

namespace uwsim::tether_contact_tests {  // other files have some of these names, too
namespace {

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

BodySpec block(const std::string& name, double mass_kg) {
  CraftParameters p;
  p.mass_kg = mass_kg;
  p.inertia_kg_m2 = mass_kg * Eigen::Vector3d(0.007, 0.007, 0.007).asDiagonal();
  p.linear_damping.diagonal() << 5, 5, 5, 1, 1, 1;
  return {name, craft_of(p, testing::box(0.2, 0.2, 0.2))};
}

TetherSpec thin(const Eigen::Vector3d& first, const Eigen::Vector3d& second, double length_m, std::uint64_t n,
                double axial_stiffness_n = 1e5) {
  return between(first, second, length_m, n, 0.05, axial_stiffness_n);
}

/// A weight that hangs over a bar from a winch.
struct OverABar {
  explicit OverABar(double friction, double step_s = kStep_s) : rig(solid_world(bar(0.5, 4, 48)), step_s) {
    rig.bodies.add_body(block("weight", 10), at(3, 0, 1));
    spec.second.body = 0;
    spec.second.point_m = {0, 0, 0.1};
    spec.friction = friction;
    spec.fastest_m_s = 1;
    tether = &rig.add(spec, vacuum(0));
  }
  double turned() const {
    const std::size_t n = tether->elements();
    const Eigen::Vector3d first = tether->position_m(1) - tether->position_m(0);
    const Eigen::Vector3d last = tether->position_m(n) - tether->position_m(n - 1);
    return std::acos(first.normalized().dot(last.normalized()));
  }
  double winch_n() const { return tether->tension_n(1); }
  double weight_n() const { return tether->tension_n(tether->elements() - 1); }

  TetherSpec spec = thin({-3, 0, 0.8}, {3, 0, 0.8}, 6.05, 60);
  Rig rig;
  Tether* tether;
};

TEST(TetherContact, FollowsTheCapstanEquation) {
  for (const double friction : {0.0, 0.2, 0.4}) {
    OverABar over(friction);
    const EvenWater water = vacuum();
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
  const EvenWater water = vacuum();
  over.rig.step(water, 6000);
  const Eigen::Vector3d before = over.tether->position_m(30);
  const double lowest = place_m(over.rig.bodies).z();
  over.rig.step(water, 4000);
  EXPECT_LT((over.tether->position_m(30) - before).norm(), 20 * 1e-4) << "no faster than friction's creep";
  EXPECT_NEAR(place_m(over.rig.bodies).z(), lowest, 20 * 1e-4);
  const double most = std::exp(0.5 * over.turned());
  EXPECT_GT(over.winch_n(), over.weight_n() / most);
  EXPECT_LT(over.winch_n(), over.weight_n() * most);
}

TEST(TetherContact, NeverGainsEnergyOnABox) {
  for (const double ea : {1e3, 1e5, 1e7}) {
    Rig rig(solid_world(testing::moved(testing::box(2, 2, 1), {0, 0, -1})));
    Tether& tether = rig.add(thin({-0.7, 0.1, 0.1}, {0.7, 0, 0.2}, 1.5, 20, ea), vacuum());
    tether.cut(0);
    const auto energy = [&] { return energy_j(tether, kGravity) + contact_energy_j(tether); };
    const double scale = 1.5 * 0.05 * kGravity;  // its weight, times a metre
    double before = energy();
    for (int k = 0; k < 1200; ++k) {
      rig.step(vacuum());
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
  Rig rig(solid_world(bar(0.3, 6, 32)));
  rig.bodies.add_body(block("rov", 12), at(2, 0, 1.2));
  TetherSpec spec = thin({-2, 0, 0.6}, {0, 0, 0}, 4.1, 40);
  spec.second.body = 0;
  spec.friction = 0.1;
  Tether& tether = rig.add(spec, vacuum(0));
  Loads down;
  down.world << 0, 0, -40, 0, 0, 0;
  rig.bodies.apply(0, down);
  rig.step(vacuum(0), 4000);
  const Eigen::Vector3d at_body = place_m(rig.bodies), pull = tether.end_force_n(1);
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
    TetherSpec spec = thin({-2, 0, 0}, {2, 0, 0}, 4.02, 40);
    Tether& tether = rig.add(spec, vacuum(0));
    const double before = 0.5 * 12;
    for (int k = 0; k < 3 / step_s; ++k) {
      rig.step(vacuum(0));
      ASSERT_LT(0.5 * 12 * velocity_m_s(rig.bodies).squaredNorm(), before * 1.01);
      ASSERT_LT(place_m(rig.bodies).z(), 0.6);
    }
    EXPECT_LT(velocity_m_s(rig.bodies).z(), 0.1) << "it is thrown back or stopped";
    EXPECT_FALSE(tether.broken());
  }
}

TEST(TetherContact, IsRefusedThroughASolid) {
  Rig rig(solid_world(testing::box(0.2, 20, 20), "wall"));
  EXPECT_EQ(refusal([&] {
              rig.add(thin({-2, 0, 0}, {2, 0, 0}, 4.5, 20), vacuum(0));
            }),
            "tether = 4.5 m from [-2 0 0] m: passes through 'wall' wherever it is laid: move an end, or use another "
            "length");
}

}  // namespace
}  // namespace uwsim::tether_contact_tests
