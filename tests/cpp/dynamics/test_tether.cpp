#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "dynamics/tethers.h"
#include "refusal.h"

namespace uwsim::tether_tests {  // other files have some of these names, too
namespace {

BodySpec block(const std::string& name, double mass_kg) {
  CraftParameters p;
  p.mass_kg = mass_kg;
  p.inertia_kg_m2 = mass_kg * Eigen::Vector3d(0.011, 0.017, 0.021).asDiagonal();
  p.linear_damping.diagonal() << 60, 60, 60, 1, 1, 1;
  return {name, craft_of(p, testing::box(0.4, 0.3, 0.2))};
}

const EvenWater kStill;

double wet_weight_n_m(const TetherSpec& spec) {
  return kGravity * (spec.mass_kg_m - 1000 * std::numbers::pi / 4 * spec.diameter_m * spec.diameter_m);
}

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
    const Tether& tether = rig.add(spec, kStill);
    rig.step(kStill, 200);
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
  EvenWater water;
  water.current_world_m_s = {0.8, 0, 0};
  Rig rig({}, 0.02);
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
  const World world = flat_bed(-20, 2, 200);
  TetherSpec spec = between({0, 0, -19.9}, {60, 0, -19.9}, 60.5, 60);
  spec.axial_stiffness_n = 1e6;
  spec.friction = 0.4;
  spec.fastest_m_s = 1;
  Rig rig(world);
  Tether& tether = rig.add(spec, kStill);
  tether.command({WinchCommand::Mode::kRate, -0.01});
  rig.step(kStill, 6000);
  tether.command({});
  rig.step(kStill, 2000);
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
  rig.step(kStill, 4000);
  EXPECT_LT((tether.position_m(30) - before).norm(), 1e-4) << "friction does not creep";
}

TEST(Tether, CarriesLongitudinalWaves) {
  TetherSpec spec = between({0, 0, -10}, {100, 0, -10}, 100, 400);
  spec.axial_stiffness_n = 1e5;
  spec.axial_damping_n_s = 0;
  spec.fastest_m_s = 10;
  Rig rig({}, 2e-5);
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
  Rig rig({}, 5e-4);
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

struct Fall {
  double axial_n, bending_n_m2, step_s;
  std::size_t elements;
  double span_m, length_m, cut_m;
  int steps;  // it is cut after half of them
};

/// Hung between two points, and then cut.
TEST(Tether, NeverGainsEnergy) {
  std::vector<Fall> falls;
  for (const double axial_n : {1e2, 1e5, 1e9}) {
    for (const double step_s : {0.001, 0.02}) falls.push_back({axial_n, 0, step_s, 30, 8, 12, 12, 400});
  }
  for (const double axial_n : {1e7, 2e9, 1e11}) {  // rods
    for (const double bending : {1.0, 400.0}) falls.push_back({axial_n, bending, 0.02, 70, 5, 8, 7.99, 200});
  }
  const EvenWater upward = vacuum(-kGravity);
  for (const Fall& fall : falls) {
    TetherSpec spec = between({0, 0, -50}, {fall.span_m, 0, -50}, fall.length_m, fall.elements, 1, fall.axial_n);
    spec.bending_stiffness_n_m2 = fall.bending_n_m2;
    spec.axial_damping_n_s = 0;
    Rig rig({}, fall.step_s);
    Tether& tether = rig.add(spec, vacuum());
    double before = energy_j(tether, -kGravity);
    for (int k = 0; k < fall.steps; ++k) {
      if (k == fall.steps / 2) tether.cut(fall.cut_m);
      rig.step(upward);
      const double now = energy_j(tether, -kGravity);
      ASSERT_LE(now, before + 1e-6 * std::abs(before)) << "EA " << fall.axial_n << " N, EI " << fall.bending_n_m2
                                                       << " N m2, step " << k << " of " << fall.step_s << " s";
      before = now;
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
  TetherSpec spec = between({0.2, 0, 0}, {-0.2, 0.05, 0}, 5, 20, 1, GetParam());
  spec.first.body = 0;
  spec.second.body = 1;
  const EvenWater water = vacuum(0);
  const Tether& tether = rig.add(spec, water);
  const auto of_bodies = [&] {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const std::size_t k : {0u, 1u})
      sum += rig.bodies.spec(k).craft->parameters().mass_kg * velocity_m_s(rig.bodies, k);
    return sum;
  };
  const auto kinetic_j = [&] {
    double sum = 0;
    for (std::size_t i = 0; i <= tether.elements(); ++i)
      sum += 0.5 * tether.mass_kg(i) * tether.velocity_m_s(i).squaredNorm();
    for (const std::size_t k : {0u, 1u}) sum += rig.bodies.spec(k).craft->kinetic_energy_j(rig.bodies.state(k));
    return sum;
  };
  const Eigen::Vector3d start = of_bodies();
  const double start_j = kinetic_j();
  double most_n = 0;
  for (int k = 0; k < 1000; ++k) {
    rig.step(water);
    // Nodes at the ends move with the bodies; their momentum is what the bodies' loads gave them in the step.
    const Eigen::Vector3d now = of_bodies() + momentum(tether);
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
  Tether& tether = rig.add(spec, kStill);
  tether.command({WinchCommand::Mode::kRate, 0.2});
  rig.step(kStill, 1000);
  EXPECT_NEAR(tether.length_m(), 33, 1e-9);
  EXPECT_NEAR(tether.rate_m_s(), 0.2, 1e-9);
  rig.step(kStill, 8000);
  EXPECT_NEAR(tether.length_m(), 40, 1e-9) << "no more is on the winch";
  tether.command({WinchCommand::Mode::kTension, 180});
  rig.step(kStill, 12000);
  EXPECT_NEAR(tether.tension_n(0), 180, 1e-6);
  EXPECT_NEAR(tether.rate_m_s(), 0, 0.02) << "it still swings, with little drag";
  const double length = tether.length_m();
  EXPECT_GT(length, 31);
  EXPECT_LT(length, 33);
  tether.command({WinchCommand::Mode::kRate, -0.5});
  rig.step(kStill, 4000);
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
  Tether& tether = rig.add(spec, kStill);
  rig.step(kStill, 100);
  rig.bodies.apply(0, {.body = Eigen::Vector<double, 6>{0, 20, 0, 0, 0, 0}, .world = Vector6d::Zero()});
  rig.step(kStill, 400);
  EXPECT_FALSE(tether.broken());
  const std::string middle = saved(rig.bodies);
  const int steps = rig.steps;
  const Loads pull{.body = ahead(400), .world = Vector6d::Zero()};
  rig.bodies.apply(0, pull);
  rig.step(kStill, 1000);
  EXPECT_TRUE(tether.broken());
  EXPECT_GT((tether.position_m(*tether.broken() + 1) - tether.position_m(*tether.broken())).norm(), 1);
  const std::string end = saved(rig.bodies);
  restore(rig.bodies, middle);
  rig.steps = steps;
  rig.bodies.apply(0, pull);
  rig.step(kStill, 1000);
  EXPECT_EQ(saved(rig.bodies), end);
}

TEST(Tether, IsRefusedIfItCannotBe) {
  const World world = flat_bed(-20, 2, 200);
  const auto refused = [&](const TetherSpec& spec) { return refusal([&] { Rig(world).add(spec, kStill); }); };
  EXPECT_EQ(refused(between({0, 0, -10}, {9, 0, -10}, 8, 8)),
            "tether length_m = 8: must be at least the distance of its ends, 9 m");
  EXPECT_EQ(refused(between({0, 0, -21}, {9, 0, -10}, 20, 8)), "tether end =   0   0 -21: must be above the bed");
  TetherSpec massless = between({0, 0, -10}, {9, 0, -10}, 20, 8);
  massless.mass_kg_m = 0;
  EXPECT_EQ(refused(massless), "tether.mass_kg_m = 0: must be positive");
  massless.mass_kg_m = 1;
  EXPECT_EQ(refused(massless), "");
}

}  // namespace
}  // namespace uwsim::tether_tests
