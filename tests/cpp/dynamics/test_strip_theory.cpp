#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <memory>
#include <numbers>
#include <span>
#include <utility>

#include "meshes.h"
#include "uwsim/vehicle/hydrodynamics.h"
#include "uwsim/world/water.h"

// The load of waves on a hull that is held at rest, compared with strip theory (Newman 1977, "Marine Hydrodynamics",
// sec. 6.17 and 7.5): the force on each strip is that of the undisturbed pressure plus the strip's added mass times the
// water's acceleration there. Strip theory neglects terms of the order of (thickness / length)^2.
namespace uwsim {
namespace {

constexpr double kPi = std::numbers::pi, kGravity = 9.80665, kAmplitude_m = 0.01;

Water with_wave(double number_rad_m) {
  const WaveComponent wave{kAmplitude_m, std::sqrt(kGravity * number_rad_m), 0, 0.4};
  Water water;
  water.waves = std::make_shared<const Waves>(std::span(&wave, 1), 1000.0);
  return water;
}

/// The wrench that the water exerts on a body at rest.
Vector6d wrench_at_rest(const CraftParameters& p, const Craft& craft, double z_m, const WaterField& water,
                        double time_s) {
  BodyState state;
  state.world_from_body.position_m.z() = z_m;
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

/// A body without added mass, in equilibrium if `density_kg_m3` is the mean density of what is in its place.
CraftParameters solid_of(const TriangleMesh& mesh, double density_kg_m3) {
  const SolidProperties solid = solid_properties(mesh);
  CraftParameters p;
  p.mass_kg = density_kg_m3 * solid.volume_m3;
  p.inertia_kg_m2 = density_kg_m3 * solid.inertia_per_density_m5;
  return p;
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

TEST(StripTheory, LoadOfASubmergedSpheroidIsThatOfItsStrips) {
  const TriangleMesh mesh = spheroid();
  CraftParameters p = solid_of(mesh, 1000);
  const double around = p.mass_kg * kHalfLength_m * kHalfLength_m / 5;  // a strip's added mass is that of its own water
  p.added_mass.diagonal() << 0.05 * p.mass_kg, p.mass_kg, p.mass_kg, 0, around, around;
  const Craft craft(p, BuoyantHull(mesh));
  for (const double lengths : {1.0, 1.3, 1.7, 2.3, 3.3, 6.0, 10.0, 16.7, 20.0}) {
    const double k = 2 * kPi / (2 * kHalfLength_m * lengths);
    const Water water = with_wave(k);
    double force = 0, moment = 0, worst_force = 0, worst_moment = 0;
    for (int phase = 0; phase < 16; ++phase) {
      const double t = 2 * kPi / std::sqrt(kGravity * k) * phase / 16;
      double strips_force = 0, strips_moment = 0;
      constexpr int kStrips = 400;
      for (int n = 0; n < kStrips; ++n) {
        const double x = kHalfLength_m * (2 * (n + 0.5) / kStrips - 1);
        const double area = kPi * kRadius_m * kRadius_m * (1 - x * x / (kHalfLength_m * kHalfLength_m));
        const double rise = water.flow_at({x, 0, -kSpheroidDepth_m}, t).wave_acceleration_m_s2.z();
        const double strip = 2 * 1000 * area * rise * 2 * kHalfLength_m / kStrips;
        strips_force += strip;
        strips_moment -= x * strip;
      }
      const Vector6d got = wrench_at_rest(p, craft, -kSpheroidDepth_m, water, t);
      force = std::max(force, std::abs(strips_force));
      moment = std::max(moment, std::abs(strips_moment));
      worst_force = std::max(worst_force, std::abs(got(2) - strips_force));
      worst_moment = std::max(worst_moment, std::abs(got(4) - strips_moment));
    }
    EXPECT_LT(worst_force, 0.05 * force) << lengths;
    EXPECT_LT(worst_moment, 0.05 * moment) << lengths;
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
    const double k = 2 * kPi / (kLength_m * lengths);
    const Water water = with_wave(k);
    double worst_force = 0, worst_moment = 0, moment = 0;
    for (int phase = 0; phase < 16; ++phase) {
      const double t = 2 * kPi / std::sqrt(kGravity * k) * phase / 16;
      double strips_force = 0, strips_moment = 0, pressure_moment = 0;
      constexpr int kStrips = 400;
      for (int n = 0; n < kStrips; ++n) {
        const double x = kLength_m * ((n + 0.5) / kStrips - 0.5), dx = kLength_m / kStrips;
        const double head = water.surface_height_at(x, 0, t) * std::exp(-k * kDraught_m);
        const double rise = water.flow_at({x, 0, -kDraught_m / 2}, t).wave_acceleration_m_s2.z();
        const double pressure = 1000 * kGravity * kBeam_m * head * dx, inertia = across / kLength_m * rise * dx;
        strips_force += pressure + inertia;
        strips_moment -= x * (pressure + inertia);
        pressure_moment -= x * pressure;
      }
      const Vector6d got = wrench_at_rest(p, craft, 0, water, t);
      worst_force = std::max(worst_force, std::abs(got(2) - strips_force));
      worst_moment = std::max(worst_moment, std::abs(got(4) - strips_moment));
      moment = std::max(moment, std::abs(pressure_moment));
    }
    EXPECT_LT(worst_force, 0.05 * 1000 * kGravity * kBeam_m * kLength_m * kAmplitude_m) << lengths;
    EXPECT_LT(worst_moment, 0.05 * moment) << lengths;
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
