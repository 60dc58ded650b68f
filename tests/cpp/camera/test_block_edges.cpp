#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>

#include "meshes.h"
#include "uwsim/camera/renderer.h"

namespace uwsim {
namespace {

constexpr int kColumns = 60, kRows = 44;

/// A box under water, in front of the surface.
World box_in_lake() {
  World world;
  world.set_terrain(Heightfield(std::vector<float>(81 * 81, -9), 81, 81, 1.0, {-40, -40}));
  TriangleMesh mesh = testing::box(0.8, 1.1, 0.6);
  for (Eigen::Vector3d& vertex : mesh.vertices_m) vertex += Eigen::Vector3d(4, 0.2, -3);
  world.add_solid("box", mesh);
  return world;
}

Picture picture(const CameraScene& scene, int right_px, int down_px) {
  Lens lens;
  lens.width = kColumns, lens.height = kRows;
  lens.fx = lens.fy = 40, lens.cx = 30 + right_px, lens.cy = 22 + down_px;
  PictureRequest request;
  request.world_from_camera = {Eigen::Vector3d(0, 0, -5),
                               Eigen::Quaterniond(Eigen::AngleAxisd(-0.5, Eigen::Vector3d::UnitY()))};
  request.keep_radiance = true;
  // These share work between neighbouring pixels, by design.
  for (const Effect shared : {Effect::kShafts, Effect::kParticles}) {
    request.effects.set(shared, false);
  }
  Optics optics;
  optics.water = jerlov_water("III");
  return render(scene, Camera("test", lens, ImageSensor{}), optics, request);
}

// Sixteen pixels are computed together: what one of them sees must not change the others.
TEST(BlockEdges, APixelDoesNotDependOnTheOthersOfItsBlock) {
  const World world = box_in_lake();
  const CameraScene scene(world, std::make_shared<RayScene>(world), 7);
  const Picture still = picture(scene, 0, 0);
  for (const auto& [right, down] : {std::pair(1, 0), std::pair(2, 3)}) {
    const Picture shifted = picture(scene, right, down);
    int on_box = 0;
    for (int v = 0; v + down < kRows; ++v) {
      for (int u = 0; u + right < kColumns; ++u) {
        const auto here = static_cast<std::size_t>(v * kColumns + u),
                   there = static_cast<std::size_t>((v + down) * kColumns + u + right);
        if (still.labels[here] != shifted.labels[there]) continue;  // at a silhouette, rounding decides
        on_box += still.labels[here] == kTerrain + 1 ? 1 : 0;
        for (std::size_t band = 0; band < 3; ++band) {
          const float one = still.radiance[3 * here + band], other = shifted.radiance[3 * there + band];
          EXPECT_NEAR(other, one, 2e-3f * one + 1e-6f) << u << " " << v;
        }
      }
    }
    EXPECT_GT(on_box, 40);
  }
}

}  // namespace
}  // namespace uwsim
