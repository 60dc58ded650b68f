#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "dynamics/bodies.h"
#include "meshes.h"
#include "uwsim/core/check.h"
#include "uwsim/dynamics/rigid_body_world.h"

namespace uwsim::tether_tests {  // other files have some of these names, too
namespace {

constexpr double kGravity = 9.80665;

BodySpec block(const std::string& name, double mass_kg) {
  const TriangleMesh mesh = testing::box(0.4, 0.3, 0.2);
  CraftParameters p;
  p.mass_kg = mass_kg;
  p.inertia_kg_m2 = mass_kg * Eigen::Vector3d(0.011, 0.017, 0.021).asDiagonal();
  p.linear_damping.diagonal() << 60, 60, 60, 1, 1, 1;
  return {name, std::make_shared<const Craft>(p, BuoyantHull(mesh))};
}

EvenWater still_water() { return {}; }

/// So thin that only gravity acts.
EvenWater vacuum(double gravity) {
  EvenWater water;
  water.density_kg_m3 = 1e-12;
  water.gravity_m_s2 = gravity;
  return water;
}

TetherSpec between(const Eigen::Vector3d& first, const Eigen::Vector3d& second, double length_m, std::uint64_t n) {
  TetherSpec spec;
  spec.first.point_m = first;
  spec.second.point_m = second;
  spec.length_m = length_m;
  spec.elements = n;
  spec.diameter_m = 0.02;
  spec.mass_kg_m = 1;
  spec.axial_stiffness_n = 1e7;
  spec.bending_stiffness_n_m2 = 0;
  return spec;
}

double wet_weight_n_m(const TetherSpec& spec) {
  return kGravity * (spec.mass_kg_m - 1000 * std::numbers::pi / 4 * spec.diameter_m * spec.diameter_m);
}

class Rig {
 public:
  explicit Rig(double step_s = kStep_s, const World& world = {}) : step_s(step_s), bodies(world, step_s) {}
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

/// Irvine (1981), "Cable Structures", 2.2: the point at `s` from the lower end of an elastic catenary [m].
Eigen::Vector2d elastic_catenary(double s, double h, double v_low, double w, double ea) {
  const double v = v_low + w * s;
  return {h * s / ea + h / w * (std::asinh(v / h) - std::asinh(v_low / h)),
          (v * v - v_low * v_low) / (2 * w * ea) + (std::hypot(h, v) - std::hypot(h, v_low)) / w};
}

TEST(Tether, HangsInACatenary) {
  for (const double ea : {1e6, 1e4}) {
    TetherSpec spec = between({0, 0, -50}, {0, 0, -50}, 60, 100);
    spec.axial_stiffness_n = ea;
    const double w = wet_weight_n_m(spec), h = 200, v_low = -100;
    const Eigen::Vector2d end = elastic_catenary(spec.length_m, h, v_low, w, ea);
    spec.second.point_m += Eigen::Vector3d(0.6 * end.x(), 0.8 * end.x(), end.y());
    Rig rig;
    const EvenWater water = still_water();
    const Tether& tether = rig.add(spec, water);
    rig.step(water, 200);
    EXPECT_NEAR(tether.end_force_n(1).head<2>().norm(), h, 2e-3 * h);
    EXPECT_NEAR(-tether.end_force_n(1).z(), v_low + w * spec.length_m, 2e-3 * w * spec.length_m);
    EXPECT_NEAR(-tether.end_force_n(0).z(), -v_low, 2e-3 * w * spec.length_m);
    for (std::size_t i = 0; i <= 100; ++i) {
      const Eigen::Vector2d at = elastic_catenary(0.6 * static_cast<double>(i), h, v_low, w, ea);
      EXPECT_NEAR(tether.position_m(i).head<2>().norm(), at.x(), 0.01);
      EXPECT_NEAR(tether.position_m(i).z() + 50, at.y(), 0.01);
    }
  }
}

TEST(Tether, LiesAtTheCriticalAngleInACurrent) {
  TetherSpec spec = between({0, 0, -20}, {0, 0, -40}, 20, 40);
  EvenWater water = still_water();
  water.current_world_m_s = {0.8, 0, 0};
  Rig rig(0.02);
  Tether& tether = rig.add(spec, water);
  tether.cut(20);  // its last element: the other end is free
  rig.step(water, 12000);
  // Pode (1951), DTMB report 687: w cos a = 1/2 rho Cn d U^2 sin^2 a.
  const double drag = 0.5 * 1000 * spec.normal_drag * spec.diameter_m * 0.64, w = wet_weight_n_m(spec);
  const double cosine = (-w + std::sqrt(w * w + 4 * drag * drag)) / (2 * drag);
  for (std::size_t i : {5u, 20u, 35u}) {
    const Eigen::Vector3d along = (tether.position_m(i + 1) - tether.position_m(i)).normalized();
    EXPECT_NEAR(std::acos(along.x()), std::acos(cosine), 1e-4);
  }
}

TEST(Tether, IsHeldByTheBedsFriction) {
  World world;
  world.set_terrain(Heightfield(std::vector<float>(4, -20), 2, 2, 200, {-100, -100}));
  TetherSpec spec = between({0, 0, -19.9}, {60, 0, -19.9}, 60.5, 60);
  spec.axial_stiffness_n = 1e6;
  spec.friction = 0.4;
  spec.fastest_m_s = 1;
  Rig rig(kStep_s, world);
  const EvenWater water = still_water();
  Tether& tether = rig.add(spec, water);
  tether.command({WinchCommand::Mode::kRate, -0.01});
  rig.step(water, 6000);
  tether.command({});
  rig.step(water, 2000);
  const double w = wet_weight_n_m(spec);
  std::size_t grounded = 0;
  for (std::size_t i = 1; i + 1 < tether.elements(); ++i) {
    const bool is_down = tether.position_m(i).z() < -19.98 && tether.position_m(i + 2).z() < -19.98;
    if (!is_down || tether.tension_n(i) == 0 || tether.tension_n(i + 1) == 0) continue;
    ++grounded;
    EXPECT_NEAR(tether.tension_n(i) - tether.tension_n(i + 1), spec.friction * w, 0.05 * w) << i;
  }
  EXPECT_GT(grounded, 10u);
  const Eigen::Vector3d before = tether.position_m(30);
  rig.step(water, 4000);
  EXPECT_LT((tether.position_m(30) - before).norm(), 1e-4) << "friction does not creep";
}

TEST(Tether, CarriesLongitudinalWaves) {
  TetherSpec spec = between({0, 0, -10}, {100, 0, -10}, 100, 400);
  spec.axial_stiffness_n = 1e5;
  spec.axial_damping_n_s = 0;
  spec.fastest_m_s = 10;
  Rig rig(2e-5);
  const EvenWater water = vacuum(0);
  Tether& tether = rig.add(spec, water);
  const double speed = std::sqrt(spec.axial_stiffness_n / spec.mass_kg_m);
  tether.command({WinchCommand::Mode::kRate, -0.1});
  double arrival_s = 0;
  const double jump_n = 0.1 * std::sqrt(spec.axial_stiffness_n * spec.mass_kg_m);
  while (tether.tension_n(tether.elements() - 1) < jump_n && rig.steps < 30000) rig.step(water);
  arrival_s = rig.steps * rig.step_s;
  EXPECT_NEAR(100 / arrival_s, speed, 0.01 * speed);
}

TEST(Tether, CarriesTransverseWaves) {
  TetherSpec spec = between({0, 0, -10}, {20, 0, -10}, 20, 60);
  spec.axial_stiffness_n = 1e6;
  spec.fastest_m_s = 1;
  Rig rig(5e-4);
  const EvenWater heavy = vacuum(kGravity), weightless = vacuum(0);
  Tether& tether = rig.add(spec, weightless);
  tether.command({WinchCommand::Mode::kRate, -0.1});
  rig.step(weightless, 200);  // 10 mm less: 500 N
  tether.command({});
  double sag = 0;
  for (int k = 0; k < 40; ++k) {  // it swings about its sag, and is let go at one end of that
    rig.step(heavy, 20);
    sag = std::min(sag, tether.position_m(30).z() + 10);
  }
  ASSERT_LT(sag, -0.05);
  int crossings = 0;
  double first_s = 0, last_s = 0, before = tether.position_m(30).z() + 10;
  for (int k = 0; k < 16000; ++k) {
    rig.step(weightless);
    const double now = tether.position_m(30).z() + 10;
    if (before < 0 && now >= 0) {
      last_s = (rig.steps - now / (now - before)) * rig.step_s;
      if (crossings++ == 0) first_s = last_s;
    }
    before = now;
  }
  ASSERT_GT(crossings, 3);
  const double mean_n = tether.end_force_n(1).norm();
  const double frequency_hz = (crossings - 1) / (last_s - first_s);
  EXPECT_NEAR(2 * 20 * frequency_hz, std::sqrt(mean_n / spec.mass_kg_m), 0.01 * std::sqrt(mean_n / spec.mass_kg_m));
}

double energy_j(const Tether& tether, double gravity) {
  double energy = 0;
  const double ea = tether.spec().axial_stiffness_n;
  for (std::size_t i = 0; i <= tether.elements(); ++i) {
    const double mass = tether.mass_kg(i);
    energy += mass * (0.5 * tether.velocity_m_s(i).squaredNorm() + gravity * tether.position_m(i).z());
    if (i == tether.elements() || tether.broken() == i) continue;
    const double rest = tether.rest_m(i);
    const double stretch = std::max(0.0, (tether.position_m(i + 1) - tether.position_m(i)).norm() - rest);
    energy += 0.5 * ea / rest * stretch * stretch;
    if (i == 0 || tether.broken() == i - 1) continue;
    const double before = tether.rest_m(i - 1);
    const Eigen::Vector3d turn = (tether.position_m(i + 1) - tether.position_m(i)) / rest -
                                 (tether.position_m(i) - tether.position_m(i - 1)) / before;
    energy += tether.spec().bending_stiffness_n_m2 / (rest + before) * turn.squaredNorm();
  }
  return energy;
}

TEST(Tether, NeverGainsEnergy) {
  for (const double ea : {1e2, 1e5, 1e9}) {
    for (const double step_s : {0.001, 0.02}) {
      TetherSpec spec = between({0, 0, -50}, {8, 0, -50}, 12, 30);
      spec.axial_stiffness_n = ea;
      spec.axial_damping_n_s = 0;
      Rig rig(step_s);
      Tether& tether = rig.add(spec, vacuum(kGravity));
      const EvenWater upward = vacuum(-kGravity);
      double before = energy_j(tether, -kGravity);
      for (int k = 0; k < 400; ++k) {
        if (k == 200) tether.cut(12);
        rig.step(upward);
        const double now = energy_j(tether, -kGravity);
        ASSERT_LE(now, before + 1e-6 * std::abs(before)) << "EA " << ea << " N, step " << k << " of " << step_s << " s";
        before = now;
      }
    }
  }
}

TEST(Tether, RodsNeverGainEnergy) {
  for (const double ea : {1e7, 2e9, 1e11}) {
    for (const double bending : {1.0, 400.0}) {
      TetherSpec spec = between({0, 0, -50}, {5, 0, -50}, 8, 70);
      spec.axial_stiffness_n = ea;
      spec.bending_stiffness_n_m2 = bending;
      spec.axial_damping_n_s = 0;
      Rig rig(0.02);
      Tether& tether = rig.add(spec, vacuum(kGravity));
      const EvenWater upward = vacuum(-kGravity);
      double before = energy_j(tether, -kGravity);
      for (int k = 0; k < 200; ++k) {
        if (k == 100) tether.cut(7.99);
        rig.step(upward);
        const double now = energy_j(tether, -kGravity);
        ASSERT_LE(now, before + 1e-6 * std::abs(before)) << "EA " << ea << " N, EI " << bending << " N m2, step " << k;
        before = now;
      }
    }
  }
}

/// Two bodies in empty space that fly apart until their tether stops them, and back.
class Snap : public ::testing::TestWithParam<double> {};

TEST_P(Snap, KeepsMomentumAndEnergy) {
  Rig rig;
  BodyState left = at(0, 0, 50), right = at(4, 0, 50);
  right.velocity_body << 2, 0.5, 0, 0, 0, 0.3;
  rig.bodies.add_body(block("left", 10), left);
  rig.bodies.add_body(block("right", 25), right);
  TetherSpec spec = between({0.2, 0, 0}, {-0.2, 0.05, 0}, 5, 20);
  spec.axial_stiffness_n = GetParam();
  spec.first.body = 0;
  spec.second.body = 1;
  const EvenWater water = vacuum(0);
  const Tether& tether = rig.add(spec, water);
  const auto momentum = [&] {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const std::size_t k : {0u, 1u}) {
      const BodyState& state = rig.bodies.state(k);
      const double mass = rig.bodies.spec(k).craft->parameters().mass_kg;
      sum += mass * state.world_from_body.direction(state.linear_body_m_s());
    }
    return sum;
  };
  const auto kinetic_j = [&] {
    double sum = 0;
    for (std::size_t i = 0; i <= tether.elements(); ++i)
      sum += 0.5 * tether.mass_kg(i) * tether.velocity_m_s(i).squaredNorm();
    for (const std::size_t k : {0u, 1u}) sum += rig.bodies.spec(k).craft->kinetic_energy_j(rig.bodies.state(k));
    return sum;
  };
  const Eigen::Vector3d start = momentum();
  const double start_j = kinetic_j();
  double most_n = 0;
  for (int k = 0; k < 1000; ++k) {
    rig.step(water);
    Eigen::Vector3d now = momentum();
    // Nodes at the ends move with the bodies; their momentum is what the bodies' loads gave them in the step.
    for (std::size_t i = 0; i <= tether.elements(); ++i) now += tether.mass_kg(i) * tether.velocity_m_s(i);
    ASSERT_LT((now - start).norm(), 0.02 * start.norm()) << k;
    ASSERT_LE(kinetic_j(), 1.02 * start_j) << k;
    most_n = std::max(most_n, tether.end_force_n(1).norm());
  }
  EXPECT_GT(most_n, 50);
}

INSTANTIATE_TEST_SUITE_P(Tether, Snap, ::testing::Values(1e3, 1e5, 1e8));

TEST(Tether, WindsAndKeepsTension) {
  TetherSpec spec = between({0, 0, -5}, {30, 0, -5}, 32, 32);
  spec.longest_m = 40;
  spec.shortest_m = 31;
  spec.fastest_m_s = 0.5;
  spec.strongest_n = 300;
  Rig rig;
  const EvenWater water = still_water();
  Tether& tether = rig.add(spec, water);
  tether.command({WinchCommand::Mode::kRate, 0.2});
  rig.step(water, 1000);
  EXPECT_NEAR(tether.length_m(), 33, 1e-9);
  EXPECT_NEAR(tether.rate_m_s(), 0.2, 1e-9);
  rig.step(water, 8000);
  EXPECT_NEAR(tether.length_m(), 40, 1e-9) << "no more is on the winch";
  tether.command({WinchCommand::Mode::kTension, 180});
  rig.step(water, 12000);
  EXPECT_NEAR(tether.tension_n(0), 180, 1e-6);
  EXPECT_NEAR(tether.rate_m_s(), 0, 0.02) << "it still swings, with little drag";
  const double length = tether.length_m();
  EXPECT_GT(length, 31);
  EXPECT_LT(length, 33);
  tether.command({WinchCommand::Mode::kRate, -0.5});
  rig.step(water, 4000);
  EXPECT_LE(tether.tension_n(0), 300 + 1e-6) << "it stalls";
  EXPECT_THROW(tether.command({WinchCommand::Mode::kRate, 0.6}), InvalidValue);
}

TEST(Tether, BreaksAndRestoresToTheSameBytes) {
  Rig rig;
  rig.bodies.add_body(block("rov", 24), at(4, 0, -10));
  TetherSpec spec = between({0, 0, -10}, {-0.2, 0, 0}, 6, 12);
  spec.second.body = 0;
  spec.axial_stiffness_n = 1e4;
  spec.breaking_load_n = 150;
  const EvenWater water = still_water();
  Tether& tether = rig.add(spec, water);
  rig.step(water, 100);
  rig.bodies.apply(0, {.body = Eigen::Vector<double, 6>{0, 20, 0, 0, 0, 0}, .world = Vector6d::Zero()});
  rig.step(water, 400);
  EXPECT_FALSE(tether.broken());
  const auto bytes = [&] {
    StateArchive saved;
    rig.bodies.exchange_state(saved);
    rig.bodies.exchange_contacts(saved);
    rig.bodies.exchange_last_step(saved);
    rig.bodies.exchange_tethers(saved);
    return saved.bytes();
  };
  const std::string middle = bytes();
  const int steps = rig.steps;
  const Loads pull{.body = Eigen::Vector<double, 6>{400, 0, 0, 0, 0, 0}, .world = Vector6d::Zero()};
  rig.bodies.apply(0, pull);
  rig.step(water, 1000);
  EXPECT_TRUE(tether.broken());
  EXPECT_GT((tether.position_m(*tether.broken() + 1) - tether.position_m(*tether.broken())).norm(), 1);
  const std::string end = bytes();
  StateArchive restored(middle);
  rig.bodies.exchange_state(restored);
  rig.bodies.exchange_contacts(restored);
  rig.bodies.exchange_last_step(restored);
  rig.bodies.exchange_tethers(restored);
  restored.finish();
  rig.steps = steps;
  rig.bodies.apply(0, pull);
  rig.step(water, 1000);
  EXPECT_EQ(bytes(), end);
}

TEST(Tether, IsRefusedIfItCannotBe) {
  World world;
  world.set_terrain(Heightfield(std::vector<float>(4, -20), 2, 2, 200, {-100, -100}));
  const EvenWater water = still_water();
  const auto refusal = [&](const TetherSpec& spec) -> std::string {
    Rig rig(kStep_s, world);
    try {
      rig.add(spec, water);
    } catch (const InvalidValue& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(refusal(between({0, 0, -10}, {9, 0, -10}, 8, 8)),
            "tether length_m = 8: must be at least the distance of its ends, 9 m");
  EXPECT_EQ(refusal(between({0, 0, -21}, {9, 0, -10}, 20, 8)), "tether end =   0   0 -21: must be above the bed");
  TetherSpec massless = between({0, 0, -10}, {9, 0, -10}, 20, 8);
  massless.mass_kg_m = 0;
  EXPECT_EQ(refusal(massless), "tether.mass_kg_m = 0: must be positive");
  massless.mass_kg_m = 1;
  EXPECT_EQ(refusal(massless), "");
}

}  // namespace
}  // namespace uwsim::tether_tests
