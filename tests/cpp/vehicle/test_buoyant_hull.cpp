#include "uwsim/vehicle/buoyant_hull.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "meshes.h"

namespace uwsim {
namespace {

const Eigen::Vector3d kTiltAxis = Eigen::Vector3d(0.3, -0.7, 0.2).normalized();

Eigen::Quaterniond tilted(double angle) { return Eigen::Quaterniond(Eigen::AngleAxisd(angle, kTiltAxis)); }

Buoyancy buoyancy(const BuoyantHull& hull, const Pose& pose, const WaterField& water, double time_s = 0) {
  return hull.buoyancy(pose.position_m, pose.rotation(), water, time_s);
}

/// Water whose density is linear between knots from the surface down, and constant beyond them.
class LayeredWater : public EvenWater {
 public:
  std::vector<double> z_m = {0, -1, -1.5, -3};
  std::vector<double> rho_kg_m3 = {998, 1003, 1021, 1025};

  bool calm_and_even() const override { return false; }
  double density_at(double z) const override { return density_layer_at(z).at(z); }
  DensityLayer density_layer_at(double z) const override {
    if (z >= z_m.front()) return {.low_m = z_m.front(), .density_kg_m3 = rho_kg_m3.front()};
    for (std::size_t k = 1; k < z_m.size(); ++k) {
      if (z < z_m[k]) continue;
      return {z_m[k], z_m[k - 1], z_m[k], rho_kg_m3[k], (rho_kg_m3[k - 1] - rho_kg_m3[k]) / (z_m[k - 1] - z_m[k])};
    }
    return {.high_m = z_m.back(), .density_kg_m3 = rho_kg_m3.back()};
  }
  DensityLayer density_layer_below(const DensityLayer& layer) const override {
    return density_layer_at(std::nextafter(layer.low_m, -1e9));
  }
  /// The integrals of rho and of rho z between two heights, by Simpson's rule between knots, which is exact.
  Eigen::Vector2d mass_between(double low, double high) const {
    std::vector<double> cuts = {low, high};
    for (const double z : z_m)
      if (low < z && z < high) cuts.push_back(z);
    std::sort(cuts.begin(), cuts.end());
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (std::size_t k = 0; k + 1 < cuts.size(); ++k) {
      const double a = cuts[k], b = cuts[k + 1], m = (a + b) / 2;
      sum += (b - a) / 6 *
             (density_at(a) * Eigen::Vector2d(1, a) + 4 * density_at(m) * Eigen::Vector2d(1, m) +
              density_at(std::nextafter(b, a)) * Eigen::Vector2d(1, b));
    }
    return sum;
  }
};

TEST(BuoyantHull, AnUprightBoxDisplacesTheVolumeBelowItsWaterline) {
  const BuoyantHull hull(testing::box(2, 1, 0.8));
  for (const double z : {-0.399, -0.2, 0.0, 0.1, 0.399}) {
    const Displacement wet = hull.displacement({{3, 4, z}, Eigen::Quaterniond::Identity()});
    const double draught = 0.4 - z;
    EXPECT_NEAR(wet.volume_m3, 2 * 1 * draught, 1e-12);
    EXPECT_LT((wet.centroid_world_m - Eigen::Vector3d(3, 4, z - 0.4 + draught / 2)).norm(), 1e-12);
  }
}

TEST(BuoyantHull, ABoxTurnedOnItsEdgeDisplacesATriangularPrism) {
  const BuoyantHull hull(testing::box(2, 1, 1));
  const Eigen::Quaterniond roll(Eigen::AngleAxisd(std::numbers::pi / 4, Eigen::Vector3d::UnitX()));
  const double z = 0.3;  // the lower edge is at z - sqrt(1/2); a right triangle of height h and width 2h is wet
  const double h = std::sqrt(0.5) - z;
  const Displacement wet = hull.displacement({{0, 0, z}, roll});
  EXPECT_NEAR(wet.volume_m3, 2 * h * h, 1e-12);
  EXPECT_LT((wet.centroid_world_m - Eigen::Vector3d(0, 0, -h / 3)).norm(), 1e-12);
}

TEST(BuoyantHull, ASphereCentredAtTheSurfaceDisplacesHalfItsVolumeAtAnyAttitude) {
  const BuoyantHull hull(testing::sphere(1, 40));
  const double whole = solid_properties(hull.mesh_body()).volume_m3;
  for (const double angle : {0.0, 0.4, 1.1, 2.9}) {
    const Displacement wet = hull.displacement({{0, 0, 0}, tilted(angle)});
    EXPECT_NEAR(wet.volume_m3, whole / 2, 1e-9 * whole);  // by point symmetry
  }
}

TEST(BuoyantHull, DisplacementIsContinuousThroughTheSurface) {
  const BuoyantHull hull(testing::box(1.2, 0.8, 0.6));
  double last = hull.displacement({{0, 0, 2}, tilted(0.5)}).volume_m3;
  EXPECT_EQ(last, 0);
  for (double z = 2; z > -2; z -= 1e-3) {
    const double volume = hull.displacement({{0, 0, z}, tilted(0.5)}).volume_m3;
    EXPECT_GE(volume, last - 1e-12);
    EXPECT_LT(volume - last, 1e-3 * 1.6) << "bounded by the waterplane's area";
    last = volume;
  }
  EXPECT_NEAR(last, 1.2 * 0.8 * 0.6, 1e-12);
}

TEST(BuoyantHull, SubmergedBuoyancyIsTheWeightOfTheWaterThroughTheCentroid) {
  TriangleMesh mesh = testing::box(1.2, 0.8, 0.6);
  for (Eigen::Vector3d& v : mesh.vertices_m) v += Eigen::Vector3d(0.3, -0.2, 0.1);
  const BuoyantHull hull(mesh);
  const Pose pose{{7, -3, -5}, tilted(0.9)};
  const Buoyancy got = buoyancy(hull, pose, EvenWater{});
  const Eigen::Vector3d force = 1000 * 9.80665 * 1.2 * 0.8 * 0.6 * (pose.rotation().transpose().col(2));
  EXPECT_LT((got.force_body_n - force).norm(), 1e-9 * force.norm());
  EXPECT_LT((got.moment_body_nm - Eigen::Vector3d(0.3, -0.2, 0.1).cross(force)).norm(), 1e-9 * force.norm());
}

TEST(BuoyantHull, InLayersTheForceOnABoxIsTheIntegralOfDensity) {
  const BuoyantHull hull(testing::box(1.2, 0.8, 1.0));
  const LayeredWater water;
  for (const double z : {0.3, -0.2, -0.5, -1.1, -1.3, -2.1, -2.2, -3.2, -9.0}) {
    const double mass = 1.2 * 0.8 * water.mass_between(z - 0.5, std::min(0.0, z + 0.5))(0);
    const Buoyancy got = buoyancy(hull, {{2, 1, z}, Eigen::Quaterniond::Identity()}, water);
    EXPECT_NEAR(got.force_body_n.z(), mass * water.gravity_m_s2, 1e-9 * mass * water.gravity_m_s2) << z;
    EXPECT_LT(got.moment_body_nm.norm(), 1e-9 * mass) << z;
  }
}

/// Bends of less than 1e-4 of the density are those of an ellipsoid: the force stays within that of the integral, and
/// is continuous in depth.
TEST(BuoyantHull, WeakBendsOfAProfileAreNotCutAndLeaveTheForceToAPartInAMillion) {
  const BuoyantHull hull(testing::box(1.2, 0.8, 1.0));
  LayeredWater water;
  water.z_m = {0, -5, -10, -20};
  water.rho_kg_m3 = {1024.40, 1024.50, 1025.13, 1025.30};  // bends of 0.1 kg/m4
  double worst = 0, before = 0;
  for (double z = -4.2; z > -11; z -= 0.01) {
    const double mass = 1.2 * 0.8 * water.mass_between(z - 0.5, z + 0.5)(0);
    const double force = buoyancy(hull, {{2, 1, z}, Eigen::Quaterniond::Identity()}, water).force_body_n.z();
    const double away = force / (mass * water.gravity_m_s2) - 1;
    worst = std::max(worst, std::abs(away));
    EXPECT_LT(std::abs(away - before), 3e-7) << z;
    before = away;
  }
  EXPECT_LT(worst, 1.5e-6);
  EXPECT_GT(worst, 1e-8);
}

TEST(BuoyantHull, InLayersTheForceActsThroughTheCentreOfTheDisplacedMass) {
  const BuoyantHull hull(testing::box(1.2, 0.8, 1.0));
  const LayeredWater water;
  for (const double z : {0.1, -0.7, -1.1, -2.4, -20.0}) {
    const Pose pose{{0, 0, z}, tilted(0.7)};
    const Eigen::Matrix3d rotation = pose.rotation();
    // The sum over thin slices of the box, each with the density at its centroid.
    double mass = 0;
    Eigen::Vector3d moment = Eigen::Vector3d::Zero();
    Displacement lower = hull.displacement(pose, z - 1);
    const int slices = 4000;
    for (int k = 1; k <= slices; ++k) {
      const double level = std::min(0.0, z - 1 + 2.0 * k / slices);
      const Displacement upper = hull.displacement(pose, level);
      const double volume = upper.volume_m3 - lower.volume_m3;
      if (volume > 0) {
        const Eigen::Vector3d first =
            upper.volume_m3 * upper.centroid_world_m - lower.volume_m3 * lower.centroid_world_m;
        mass += water.density_at(first.z() / volume) * volume;
        moment += water.density_at(first.z() / volume) * (first - volume * pose.position_m);
      }
      lower = upper;
    }
    const Eigen::Vector3d up(0, 0, water.gravity_m_s2);
    const Buoyancy got = buoyancy(hull, pose, water);
    EXPECT_NEAR((rotation * got.force_body_n).z(), mass * up.z(), 1e-6 * mass * up.z()) << z;
    EXPECT_LT((rotation * got.moment_body_nm - moment.cross(up)).norm(), 1e-5 * mass * up.z()) << z;
  }
}

}  // namespace
}  // namespace uwsim
