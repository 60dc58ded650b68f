#include "uwsim/vehicle/added_mass.h"

#include <gtest/gtest.h>

#include <cmath>

#include "meshes.h"
#include "uwsim/core/check.h"
#include "uwsim/vehicle/panels.h"

namespace uwsim {
namespace {

TEST(AddedMass, OfASphereIsHalfOfWhatItDisplaces) {
  const TriangleMesh sphere = testing::sphere(1, 12);
  const Matrix6d mass = added_mass(sphere, 1000, 1);
  const double displaced_kg = 1000 * solid_properties(sphere).volume_m3;
  EXPECT_LT((mass.topLeftCorner(3, 3) - displaced_kg / 2 * Eigen::Matrix3d::Identity()).norm(), 5e-3 * displaced_kg);
  EXPECT_LT(mass.bottomRightCorner(3, 3).norm(), 5e-3 * displaced_kg);
}

TEST(AddedMass, OfACubeIsThatOfItsPolarizability) {
  const Matrix6d mass = added_mass(refined(testing::box(1, 1, 1), 800), 1, 1);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(mass(k, k), 0.6383, 0.002) << "Sihvola et al. 2004";
}

TEST(AddedMass, GrowsWithThePanels) {
  double last = 0;
  for (const std::size_t panels : {100, 200, 400}) {
    const Matrix6d mass = added_mass(refined(testing::box(1, 0.3, 0.2), panels), 1, 1);
    EXPECT_GT(mass(5, 5), last);
    last = mass(5, 5);
  }
}

TEST(AddedMass, IsTheSameWithAnyNumberOfThreads) {
  const TriangleMesh box = refined(testing::box(1, 0.5, 0.1), 300);
  EXPECT_EQ(added_mass(box, 1, 1), added_mass(box, 1, 3));
}

TEST(AddedMass, OfTwoBodiesNeedsNoPotentialThatIsConstantOnEither) {
  TriangleMesh pair = testing::box(1, 1, 1);
  const auto own = static_cast<std::uint32_t>(pair.vertices_m.size());
  for (std::uint32_t k = 0; k < own; ++k) pair.vertices_m.push_back(pair.vertices_m[k] + Eigen::Vector3d(100, 0, 0));
  for (std::size_t k = 0; k < 12; ++k) {
    const Triangle t = pair.triangles[k];
    pair.triangles.push_back({t[0] + own, t[1] + own, t[2] + own});
  }
  const double single_kg = added_mass(testing::box(1, 1, 1), 1, 1)(0, 0);
  EXPECT_NEAR(added_mass(pair, 1, 1)(0, 0), 2 * single_kg, 1e-3 * single_kg);
}

TEST(Panels, KeepTheSurface) {
  const TriangleMesh box = testing::box(1.2, 0.8, 0.05), panels = refined(box, 700);
  EXPECT_GE(panels.triangles.size(), 700u);
  EXPECT_LE(panels.triangles.size(), 701u);
  require_closed(panels, "panels");
  EXPECT_NEAR(solid_properties(panels).volume_m3, solid_properties(box).volume_m3, 1e-12);
  EXPECT_THROW(added_mass(refined(box, 10001), 1, 1), InvalidValue);
}

}  // namespace
}  // namespace uwsim
