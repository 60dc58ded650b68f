#include "uwsim/camera/thin_solids.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "meshes.h"
#include "uwsim/camera/renderer.h"
#include "uwsim/core/random.h"

namespace uwsim {
namespace {

constexpr double kAway_m = 6, kRopePixels = 0.6;
constexpr int kColumns = 64, kRows = 48;

/// A view of a rope as wide as a part of a pixel, or of a wall that begins where it does, from 6 m.
Picture view_of(double width_m, double lean_rad, int threads = 1) {
  Lens lens;
  lens.width = kColumns, lens.height = kRows;
  lens.fx = lens.fy = 100, lens.cx = 31.5, lens.cy = 23.5;
  TriangleMesh rope = testing::box(width_m, width_m, 30);
  const Eigen::AngleAxisd lean(lean_rad, Eigen::Vector3d::UnitX());
  for (Eigen::Vector3d& at : rope.vertices_m) at = lean * at + Eigen::Vector3d(kAway_m + 0.5 * width_m, 0.013, 0);
  World world;
  world.add_solid("rope", rope);
  CameraScene scene(world, std::make_shared<RayScene>(world), 7);
  scene.set_appearance(kTerrain + 1, {material("plain", Bands(0.9, 0.9, 0.9)), SurfaceClass::kStructure, {}});
  PictureRequest request;
  request.effects = Effects::none();
  request.keep_radiance = true, request.threads = threads;
  Optics optics;
  optics.water = jerlov_water("III");
  return render(scene, Camera("c", lens, {}), optics, request);
}

TEST(ThinSolids, ThicknessIsTheDiameterOfAStrand) {
  EXPECT_NEAR(mean_thickness_m(testing::box(0.02, 0.02, 50)), 0.02, 1e-5);  // four times a square over its sides
  EXPECT_GT(mean_thickness_m(testing::sphere(1, 20)), 1.2);                 // 4 / 3 of the radius
}

// A ray that meets a box where its solid matters is never left out, nor one that differs from it by less than `aside`;
// few others are let in, and all kernels agree.
TEST(ThinSolids, RaysThatMayMeetThemAreFoundByTheirBoxes) {
  const RandomStream random(3, "boxes");
  constexpr float kAside = 0.02f, kLeast_m = 2;
  std::vector<ThinSolid> solids;
  for (std::uint64_t k = 0; k < 20; ++k) {
    const Eigen::Vector3d middle(4 * random.normal(k, 0), 4 * random.normal(k, 1), 4 * random.normal(k, 2));
    const Eigen::Vector3d half(0.3 * random.uniform(k, 3), 0.3 * random.uniform(k, 4), 0.02);
    solids.push_back({static_cast<std::uint32_t>(k + 2), 0.02f, middle - half, middle + half});
  }
  const Eigen::Vector3f from(0.1f, -0.2f, 0.05f);
  const ThinSolidsAround around(solids, std::vector<float>(solids.size(), kLeast_m), Eigen::Vector3d::Zero(), kAside);
  int met = 0, found = 0;
  for (std::uint64_t k = 0; k < 4000; ++k) {
    const ThinSolid& solid = solids[k % solids.size()];
    Eigen::Vector3d to;  // a point of a box in half of the cases
    for (int axis = 0; axis < 3; ++axis) {
      const double share = random.uniform(k, static_cast<std::uint32_t>(20 + axis));
      to(axis) = k % 2 == 0 ? solid.low_m(axis) + share * (solid.high_m(axis) - solid.low_m(axis)) : share - 0.5;
    }
    const Eigen::Vector3d way = to - from.cast<double>(), direction = way.normalized();
    const Eigen::Vector3d off(random.uniform(k, 30) - 0.5, random.uniform(k, 31) - 0.5, random.uniform(k, 32) - 0.5);
    const Eigen::Vector3f asked = (direction + 1.9 * double{kAside} * off).cast<float>();
    const bool may_meet = around.may_be_met(camera::kernels(), from, asked);
    EXPECT_EQ(around.may_be_met(camera::baseline_kernels(), from, asked), may_meet) << k;
    if (k % 2 == 0 && way.norm() > double{kLeast_m}) {
      EXPECT_TRUE(may_meet) << k;
      ++met;
    } else if (k % 2 == 1) {
      found += may_meet ? 1 : 0;
    }
  }
  EXPECT_GT(met, 1000);
  EXPECT_LT(found, 400);
}

// A rope covers the share of its pixels that its width is of theirs, in each row, not all of one pixel in some rows.
TEST(ThinSolids, ARopeCoversItsShareOfPixels) {
  const double pixel_m = kAway_m / 100;
  const Picture rope = view_of(kRopePixels * pixel_m, 0.12), none = view_of(1e-7, 1.5), wide = view_of(5, 0);
  const auto green = [](const Picture& picture, int u, int v) {
    return double{picture.radiance[static_cast<std::size_t>(3 * (v * kColumns + u) + 1)]};
  };
  double sum = 0, largest = 0;
  for (int v = 8; v < 40; ++v) {
    double covered = 0;
    for (int u = 8; u < 56; ++u) {
      const double share = (green(rope, u, v) - green(none, u, v)) / (green(wide, u, v) - green(none, u, v));
      covered += share, largest = std::max(largest, share);
    }
    EXPECT_NEAR(covered, kRopePixels, 0.3) << v;
    sum += covered / 32;
  }
  EXPECT_NEAR(sum, kRopePixels / std::cos(0.12), 0.04);
  EXPECT_LT(largest, 0.85);
}

TEST(ThinSolids, PicturesDoNotDependOnThreads) {
  EXPECT_EQ(view_of(0.03, 0.12, 3).radiance, view_of(0.03, 0.12, 1).radiance);
}

}  // namespace
}  // namespace uwsim
