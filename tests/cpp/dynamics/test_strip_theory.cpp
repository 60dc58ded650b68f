#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <memory>
#include <numbers>
#include <span>
#include <utility>

#include "dynamics/bodies.h"
#include "uwsim/vehicle/hydrodynamics.h"
#include "uwsim/world/water.h"

// The load of waves on a hull that is held at rest, compared with strip theory (Newman 1977, "Marine Hydrodynamics",
// sec. 6.17 and 7.5): the force on each strip is that of the undisturbed pressure plus the strip's added mass times the
// water's acceleration there. Strip theory neglects terms of the order of (thickness / length)^2.
namespace uwsim {
namespace {

constexpr double kPi = std::numbers::pi, kAmplitude_m = 0.01;

Water with_wave(double number_rad_m) {
  const WaveComponent wave{kAmplitude_m, std::sqrt(kGravity * number_rad_m), 0, 0.4};
  Water water;
  water.waves = std::make_shared<const Waves>(std::span(&wave, 1), 1000.0);
  return water;
}

/// The wrench that the water exerts on a body at rest.
Vector6d wrench_at_rest(const CraftParameters& p, const Craft& craft, double z_m, const WaterField& water,
                        double time_s) {
  const BodyState state = at(0, 0, z_m);
  const Vector6d rate = craft.acceleration_body(state, Vector6d::Zero(), water, time_s);
  Matrix6d mass = craft.submerged_fraction(state.world_from_body, water, time_s) * p.added_mass;
  mass.topLeftCorner<3, 3>() += p.mass_kg * Eigen::Matrix3d::Identity();
  mass.bottomRightCorner<3, 3>() += p.inertia_kg_m2;
  return mass * rate;
}

constexpr double kHalfLength_m = 3, kRadius_m = 0.4, kSpheroidDepth_m = 3;      // the spheroid
constexpr double kLength_m = 2 * kHalfLength_m, kBeam_m = 2, kDraught_m = 0.3;  // the barge

TriangleMesh spheroid() {
  TriangleMesh mesh = testing::sphere(kRadius_m, 40);
  for (Eigen::Vector3d& v : mesh.vertices_m) v = {v.z() * kHalfLength_m / kRadius_m, v.x(), v.y()};
  return mesh;
}

/// Heave [N] and pitch [N m] per metre of amplitude by Capytaine 3.0.0 (froude_krylov_force, deep water, head waves;
/// the barge with 48 x 16 x 6 panels, the spheroid with 24 x 48).
TEST(StripTheory, ForceOfTheUndisturbedPressureIsThatOfAPanelCode) {
  struct Row {
    double lengths, barge_n, barge_nm, spheroid_n, spheroid_nm;
  };
  constexpr Row kRows[] = {{1.0, 0, 82138, 278.81, 768.6},         {1.2, 17307, 1.09e5, 588.53, 1151.6},
                           {1.6, 45513, 1.2462e5, 1206.3, 1567.8}, {2.3, 73593, 1.1413e5, 1885.9, 1595.1},
                           {4.0, 97951, 79073, 2199, 1029.9},      {8.0, 110260, 43075, 1704.5, 393.91},
                           {20.0, 115370, 17871, 873.94, 80.497}};
  const CraftParameters light = solid_of(testing::box(kLength_m, kBeam_m, 2 * kDraught_m), 500);
  const CraftParameters neutral = solid_of(spheroid(), 1000);
  const Craft barge(light, BuoyantHull(testing::box(kLength_m, kBeam_m, 2 * kDraught_m)));
  const Craft submerged(neutral, BuoyantHull(spheroid()));
  for (const Row& row : kRows) {
    const double k = 2 * kPi / (kLength_m * row.lengths), quarter_s = kPi / 2 / std::sqrt(kGravity * k);
    const Water water = with_wave(k);
    const auto amplitude = [&](const CraftParameters& p, const Craft& craft, double z_m) -> Vector6d {
      const Vector6d one = wrench_at_rest(p, craft, z_m, water, 0),
                     other = wrench_at_rest(p, craft, z_m, water, quarter_s);
      return (one.cwiseAbs2() + other.cwiseAbs2()).cwiseSqrt() / kAmplitude_m;
    };
    const Vector6d floating = amplitude(light, barge, 0), below = amplitude(neutral, submerged, -kSpheroidDepth_m);
    EXPECT_NEAR(floating(2), row.barge_n, 0.02 * 115370) << row.lengths;
    EXPECT_NEAR(floating(4), row.barge_nm, 0.02 * row.barge_nm) << row.lengths;
    EXPECT_NEAR(below(2), row.spheroid_n, 0.02 * row.spheroid_n) << row.lengths;
    EXPECT_NEAR(below(4), row.spheroid_nm, 0.05 * row.spheroid_nm) << row.lengths;
  }
}

/// Heave force and pitch moment.
using Strips = Eigen::Vector2d;

/// The greatest load of a wave over its period by strips of a hull, and the greatest difference of a craft's from it.
struct Compared {
  Strips most = Strips::Zero(), missed = Strips::Zero();
};

/// `strip(x, t)`: the force per metre at `x`.
template <typename Strip>
Compared compared(const CraftParameters& p, const Craft& craft, double z_m, const Water& water, double period_s,
                  const Strip& strip) {
  constexpr int kStrips = 400, kPhases = 16;
  Compared found;
  for (int phase = 0; phase < kPhases; ++phase) {
    const double t = period_s * phase / kPhases, dx = kLength_m / kStrips;
    Strips strips = Strips::Zero();
    for (int n = 0; n < kStrips; ++n) {
      const double x = kLength_m * ((n + 0.5) / kStrips - 0.5);
      strips += strip(x, t) * dx * Strips(1, -x);
    }
    const Vector6d got = wrench_at_rest(p, craft, z_m, water, t);
    found.most = found.most.cwiseMax(strips.cwiseAbs());
    found.missed = found.missed.cwiseMax((Strips(got(2), got(4)) - strips).cwiseAbs());
  }
  return found;
}

TEST(StripTheory, LoadOfASubmergedSpheroidIsThatOfItsStrips) {
  const TriangleMesh mesh = spheroid();
  CraftParameters p = solid_of(mesh, 1000);
  const double around = p.mass_kg * kHalfLength_m * kHalfLength_m / 5;  // a strip's added mass is that of its own water
  p.added_mass.diagonal() << 0.05 * p.mass_kg, p.mass_kg, p.mass_kg, 0, around, around;
  const Craft craft(p, BuoyantHull(mesh));
  for (const double lengths : {1.0, 1.3, 1.7, 2.3, 3.3, 6.0, 10.0, 16.7, 20.0}) {
    const double k = 2 * kPi / (kLength_m * lengths);
    const Water water = with_wave(k);
    const auto strip = [&](double x, double t) {
      const double area = kPi * kRadius_m * kRadius_m * (1 - x * x / (kHalfLength_m * kHalfLength_m));
      return 2 * 1000 * area * water.flow_at({x, 0, -kSpheroidDepth_m}, t).wave_acceleration_m_s2.z();
    };
    const Compared load = compared(p, craft, -kSpheroidDepth_m, water, 2 * kPi / std::sqrt(kGravity * k), strip);
    EXPECT_LT(load.missed[0], 0.05 * load.most[0]) << lengths;
    EXPECT_LT(load.missed[1], 0.05 * load.most[1]) << lengths;
  }
}

/// The errors are relative to the moment of the pressure alone, since the added mass cancels much of it, and to the
/// heave force in long waves, since waves of the barge's length do not lift it.
TEST(StripTheory, LoadOfAFloatingBargeIsThatOfItsStrips) {
  const TriangleMesh mesh = testing::box(kLength_m, kBeam_m, 2 * kDraught_m);
  CraftParameters p = solid_of(mesh, 500);
  const double across = 1000 * kPi / 8 * kBeam_m * kBeam_m * kLength_m;  // half of a cylinder of this beam
  const double around = across * kLength_m * kLength_m / 12;
  p.added_mass.diagonal() << 100, 2 * across, 2 * across, 0, 2 * around, 2 * around;  // half of it is submerged
  const Craft craft(p, BuoyantHull(mesh));
  for (const double lengths : {1.0, 1.2, 1.6, 2.3, 4.0, 8.0, 20.0}) {
    const double k = 2 * kPi / (kLength_m * lengths), period_s = 2 * kPi / std::sqrt(kGravity * k);
    const Water water = with_wave(k);
    const auto pressure = [&](double x, double t) {
      return 1000 * kGravity * kBeam_m * water.surface_height_at(x, 0, t) * std::exp(-k * kDraught_m);
    };
    const auto strip = [&](double x, double t) {
      const double rise = water.flow_at({x, 0, -kDraught_m / 2}, t).wave_acceleration_m_s2.z();
      return pressure(x, t) + across / kLength_m * rise;
    };
    const Strips missed = compared(p, craft, 0, water, period_s, strip).missed;
    EXPECT_LT(missed[0], 0.05 * 1000 * kGravity * kBeam_m * kLength_m * kAmplitude_m) << lengths;
    EXPECT_LT(missed[1], 0.05 * compared(p, craft, 0, water, period_s, pressure).most[1]) << lengths;
  }
}

/// The force per metre of a slender box varies as cos(k x + phase): the integrals have closed forms.
TEST(StripTheory, LoadOfASlenderBoxHasAClosedForm) {
  constexpr double kSide_m = 0.1, kShare = 0.7;
  const TriangleMesh mesh = testing::box(kLength_m, kSide_m, kSide_m);
  CraftParameters p = solid_of(mesh, 1000);
  const double around = kShare * p.mass_kg * kLength_m * kLength_m / 12;
  p.added_mass.diagonal() << 0, kShare * p.mass_kg, kShare * p.mass_kg, 0, around, around;
  const Craft craft(p, BuoyantHull(mesh));
  for (const double lengths : {1.0, 1.5, 2.0, 5.0, 20.0, 200.0}) {
    const double k = 2 * kPi / (kLength_m * lengths), u = k * kLength_m / 2, omega2 = kGravity * k;
    const Water water = with_wave(k);
    const double force = (1 + kShare) * p.mass_kg * omega2 * kAmplitude_m * std::exp(-k * kSpheroidDepth_m);
    for (int eighth = 0; eighth < 8; ++eighth) {
      const double phase = kPi * eighth / 4;
      const Vector6d got = wrench_at_rest(p, craft, -kSpheroidDepth_m, water, (0.4 - phase) / std::sqrt(omega2));
      EXPECT_NEAR(got(2), -force * std::sin(u) / u * std::cos(phase), 0.015 * force) << lengths;
      // The integral of -x cos(k x + phase) / L.
      const double arm_m = (std::sin(u) - u * std::cos(u)) / (k * u);
      EXPECT_NEAR(got(4), -force * arm_m * std::sin(phase), 0.015 * force * kLength_m / 4) << lengths;
    }
  }
}

/// A sea has waves much shorter than the hull.
TEST(StripTheory, FlowOverALongHullIsTheMeanOfTheFlowInIt) {
  const Eigen::Vector3d size(4, 0.4, 0.4), middle(3, -2, -0.9);
  const BuoyantHull hull(testing::box(size.x(), size.y(), size.z()));
  Water water;
  water.waves =
      std::make_shared<const Waves>(Waves::jonswap({.significant_height_m = 0.3, .peak_period_s = 2.5, .seed = 3}, 40));
  double missed = 0, all = 0, missed_turn = 0, all_turn = 0;
  for (int k = 0; k < 12; ++k) {
    const Eigen::Matrix3d rotation = Eigen::AngleAxisd(0.3 * k, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    const VolumeFlow got = hull.buoyancy(middle, rotation, water, 7.3 * k).flow;
    constexpr int kAlong = 80, kAcross = 4;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    double turning = 0, inertia = 0;
    for (int n = 0; n < kAlong * kAcross * kAcross; ++n) {
      const auto at = [](int i, int count) { return (i + 0.5) / count - 0.5; };
      const Eigen::Vector3d unit(at(n / (kAcross * kAcross), kAlong), at(n / kAcross % kAcross, kAcross),
                                 at(n % kAcross, kAcross));
      const Eigen::Vector3d arm = size.cwiseProduct(unit);
      const Eigen::Vector3d v = water.flow_at(middle + rotation * arm, 7.3 * k).velocity_m_s;
      mean += v / (kAlong * kAcross * kAcross);
      turning -= arm.x() * v.z();
      inertia += arm.x() * arm.x();
    }
    missed += (got.velocity_m_s - mean).squaredNorm();
    all += mean.squaredNorm();
    const double turn = rotation.col(1).dot(got.angular_velocity_rad_s), reference = turning / inertia;
    missed_turn += (turn - reference) * (turn - reference);
    all_turn += reference * reference;
  }
  EXPECT_LT(std::sqrt(missed / all), 0.05);
  EXPECT_LT(std::sqrt(missed_turn / all_turn), 0.1);
}

TEST(StripTheory, ATallBodyIsTurnedByTheShearOfACurrent) {
  const TriangleMesh mesh = testing::box(0.2, 0.2, 4);
  CraftParameters p = solid_of(mesh, 1000);
  p.linear_damping.diagonal() << 10, 10, 10, 70, 70, 5;
  const Craft craft(p, BuoyantHull(mesh));
  Water water;
  water.currents = {layered_current({2, 10}, {{0.8, 0.4, 0}, {0, 0, 0}})};
  const Vector6d got = wrench_at_rest(p, craft, -6, water, 0);
  EXPECT_NEAR(got(4), 70 * 0.1, 0.05);
  EXPECT_NEAR(got(3), -70 * 0.05, 0.05);
  EXPECT_NEAR(got(0), 10 * 0.4, 0.01);
}

}  // namespace
}  // namespace uwsim
