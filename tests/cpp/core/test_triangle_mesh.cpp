#include "uwsim/core/triangle_mesh.h"

#include <gtest/gtest.h>

#include "meshes.h"
#include "uwsim/core/check.h"

namespace uwsim {
namespace {

TEST(TriangleMesh, ABoxHasItsVolumeCentroidAndInertiaAwayFromTheOrigin) {
  TriangleMesh mesh = testing::box(2, 3, 4);
  for (auto& v : mesh.vertices_m) v += Eigen::Vector3d(10, -20, 30);
  const SolidProperties solid = solid_properties(mesh);
  EXPECT_NEAR(solid.volume_m3, 24, 1e-9);
  EXPECT_LT((solid.centroid_m - Eigen::Vector3d(10, -20, 30)).norm(), 1e-9);
  const Eigen::Vector3d expected = 24.0 / 12 * Eigen::Vector3d(9 + 16, 4 + 16, 4 + 9);
  EXPECT_LT((solid.inertia_per_density_m5 - Eigen::Matrix3d(expected.asDiagonal())).norm(), 1e-8);
}

TEST(TriangleMesh, OpenInvertedAndEmptyMeshesAreRefused) {
  TriangleMesh open = testing::box(1, 1, 1);
  open.triangles.pop_back();
  EXPECT_THROW(require_closed(open, "hull"), InvalidValue);
  TriangleMesh inverted = testing::box(1, 1, 1);
  for (Triangle& t : inverted.triangles) std::swap(t[0], t[1]);
  EXPECT_THROW(require_closed(inverted, "hull"), InvalidValue);
  EXPECT_THROW(require_closed({}, "hull"), InvalidValue);
  EXPECT_NO_THROW(require_closed(testing::sphere(1, 8), "hull"));
}

}  // namespace
}  // namespace uwsim
