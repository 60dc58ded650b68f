#include "uwsim/vehicle/buoyant_hull.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "meshes.h"

namespace uwsim {
namespace {

const Eigen::Vector3d kTiltAxis = Eigen::Vector3d(0.3, -0.7, 0.2).normalized();

TEST(BuoyantHull, AnUprightBoxDisplacesItsDraught) {
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
  const double z = 0.3;  // the lower edge is at z - sqrt(1/2): a right triangle of height h is wet, its width 2h
  const double h = std::sqrt(0.5) - z;
  const Displacement wet = hull.displacement({{0, 0, z}, roll});
  EXPECT_NEAR(wet.volume_m3, 2 * h * h, 1e-12);
  EXPECT_LT((wet.centroid_world_m - Eigen::Vector3d(0, 0, -h / 3)).norm(), 1e-12);
}

TEST(BuoyantHull, HalfASphereIsHalfItsVolumeAtAnyAttitude) {
  const BuoyantHull hull(testing::sphere(1, 40));
  const double whole = solid_properties(hull.mesh_body()).volume_m3;
  for (const double angle : {0.0, 0.4, 1.1, 2.9}) {
    const Displacement wet = hull.displacement({{0, 0, 0}, Eigen::Quaterniond(Eigen::AngleAxisd(angle, kTiltAxis))});
    EXPECT_NEAR(wet.volume_m3, whole / 2, 1e-9 * whole);  // point symmetry
  }
}

TEST(BuoyantHull, IsContinuousThroughTheSurface) {
  const BuoyantHull hull(testing::box(1.2, 0.8, 0.6));
  const Eigen::Quaterniond tilt(Eigen::AngleAxisd(0.5, kTiltAxis));
  double last = hull.displacement({{0, 0, 2}, tilt}).volume_m3;
  EXPECT_EQ(last, 0);
  for (double z = 2; z > -2; z -= 1e-3) {
    const double volume = hull.displacement({{0, 0, z}, tilt}).volume_m3;
    EXPECT_GE(volume, last - 1e-12);
    EXPECT_LT(volume - last, 1e-3 * 1.6) << "no more than the waterplane's area can take";
    last = volume;
  }
  EXPECT_NEAR(last, 1.2 * 0.8 * 0.6, 1e-12);
}

}  // namespace
}  // namespace uwsim
