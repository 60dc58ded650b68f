#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "meshes.h"
#include "uwsim/core/check.h"
#include "uwsim/core/instruction_set.h"
#include "uwsim/core/random.h"
#include "uwsim/rays/cover_trees.h"
#include "uwsim/rays/ray_kernels.h"
#include "uwsim/rays/ray_lanes.h"
#include "uwsim/rays/ray_scene.h"

namespace uwsim {
namespace {

constexpr double kDepth_m = 8;

/// A plane bed, 60 m wide, with boxes of 0.2 to 1 m on it.
World bed_with_boxes(double density_per_m2 = 0.5) {
  World world;
  world.set_terrain(Heightfield(std::vector<float>(61 * 61, -kDepth_m), 61, 61, 1.0, {-30, -30}));
  CoverLayer layer;
  layer.name = "boxes";
  layer.meshes = {testing::box(1, 0.6, 0.8), testing::box(0.5, 1, 1)};
  layer.density_per_m2 = density_per_m2;
  layer.size_m = {0.2, 1};
  world.add_cover(layer);
  return world;
}

/// The same bed with boxes that lean in a current and sway in waves.
World bed_with_plants() {
  World world = bed_with_boxes();
  World swaying;
  swaying.set_terrain(*world.terrain());
  CoverLayer layer = *world.cover()[0];
  layer.leans_at_m_s = 0.5;
  swaying.add_cover(layer);
  swaying.water.current_world_m_s = {0.1, -0.2, 0};
  const WaveComponent wave{.amplitude_m = 0.5, .angular_frequency_rad_s = 1.1, .heading_rad = 0.4, .phase_rad = 0.3};
  swaying.water.waves = std::make_shared<const Waves>(std::span(&wave, 1), kDepth_m);
  return swaying;
}

/// How far a point of a piece moves as it leans.
Eigen::Vector3d lean(const World& world, const CoverTilePlan& tile, const CoverPiece& piece, const Sway* sway,
                     double height_m) {
  if (sway == nullptr) return Eigen::Vector3d::Zero();
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const CoverPiece& each : tile.pieces)
    middle += each.at_m.cast<double>() / static_cast<double>(tile.pieces.size());
  const Eigen::Vector2d top = sway->lean(*world.cover()[0], tile.middle_m + middle);
  const double uneven = 0.2 * (2 * std::fmod(0.6180339887498949 * piece.number, 1.0) - 1);
  const double angle = std::atan((1 + uneven) * top.norm());
  const Eigen::Vector2d aside = std::sin(angle) * top.normalized();
  return height_m * Eigen::Vector3d(aside.x(), aside.y(), std::cos(angle) - 1);
}

/// The same pieces as fixed solids.
World with_solids(const World& world, const Sway* sway) {
  const CoverPlan plan(world);
  World fixed;
  fixed.set_terrain(*world.terrain());
  for (std::uint32_t row = 0; row < plan.rows(); ++row) {
    for (std::uint32_t column = 0; column < plan.columns(); ++column) {
      const CoverTilePlan tile = plan.pieces(column, row);
      for (const CoverPiece& piece : tile.pieces) {
        TriangleMesh mesh = world.cover()[0]->meshes[piece.mesh];
        for (Eigen::Vector3d& v : mesh.vertices_m) {
          const Eigen::Vector3d upright = piece.turn.cast<double>() * v.cast<float>().cast<double>();
          v = tile.middle_m + piece.at_m.cast<double>() + upright + lean(world, tile, piece, sway, upright.z());
        }
        fixed.add_solid("piece" + std::to_string(piece.number), mesh);
      }
    }
  }
  return fixed;
}

std::vector<Ray> rays_from_above(int count) {
  const RandomStream random(1, "cover rays");
  std::vector<Ray> rays;
  for (int k = 0; k < count; ++k) {
    const auto draw = [&](std::uint32_t what) { return random.uniform(static_cast<std::uint64_t>(k), what); };
    rays.push_back({{50 * draw(0) - 25, 50 * draw(1) - 25, -kDepth_m + 4 * draw(2)},
                    Eigen::Vector3d(draw(3) - 0.5, draw(4) - 0.5, -0.5 * draw(5)).normalized()});
  }
  return rays;
}

/// Pieces that stand still, and pieces that lean.
class CoverInWater : public ::testing::TestWithParam<bool> {
 protected:
  World world = GetParam() ? bed_with_plants() : bed_with_boxes();
  std::shared_ptr<const Sway> sway = Sway::of(world, 7.3);
  RayScene cover = RayScene(world).with_plants(sway);
};

INSTANTIATE_TEST_SUITE_P(Cover, CoverInWater, ::testing::Bool());

TEST_P(CoverInWater, RaysMeetPiecesAsTheyMeetEqualSolids) {
  EXPECT_EQ(sway != nullptr, GetParam());
  const RayScene solids(with_solids(world, sway.get()));
  const std::vector<Ray> rays = rays_from_above(4000);
  std::vector<RayHit> met(rays.size()), expected(rays.size());
  cover.cast(rays, 60, met, 2);
  solids.cast(rays, 60, expected);
  int pieces = 0, other = 0;
  for (std::size_t k = 0; k < rays.size(); ++k) {
    if (std::abs(met[k].distance_m - expected[k].distance_m) > 1e-6) {
      ++other;  // at a silhouette, float decides
      continue;
    }
    EXPECT_EQ(met[k].label == 2, expected[k].label >= 2) << k;
    pieces += met[k].label == 2 ? 1 : 0;
  }
  EXPECT_LE(other, 4);
  EXPECT_GT(pieces, 500);
}

TEST(Cover, RaysMeetPiecesOverACoarseBed) {
  World world;  // whose nodes are farther apart than its tiles are wide
  world.set_terrain(Heightfield(std::vector<float>(7 * 7, -kDepth_m), 7, 7, 10.0, {-30, -30}));
  CoverLayer layer = *bed_with_boxes().cover()[0];
  layer.density_per_m2 = 50;
  world.add_cover(layer);
  const RayScene scene(world);
  int pieces = 0;
  for (const PlacedPiece& piece : scene.cover_in({Eigen::Vector2d(-8, -8), Eigen::Vector2d(8, 8)})) {
    if (++pieces % 100 != 0) continue;
    EXPECT_EQ(scene.cast({piece.position_world_m + Eigen::Vector3d(0, 0, 5), -Eigen::Vector3d::UnitZ()}, 60).label, 2);
  }
  EXPECT_GT(pieces, 5000);
}

TEST_P(CoverInWater, PicturesAndShadowsAgreeWithExactRays) {
  const RayScene& scene = cover;
  const std::vector<Ray> rays = rays_from_above(1600);
  int other = 0;
  for (std::size_t first = 0; first < rays.size(); first += kPacketRays) {
    RayPacket packet{};
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      const Ray& ray = rays[first + k];
      packet.origin_x[k] = static_cast<float>(ray.origin_world_m.x());
      packet.origin_y[k] = static_cast<float>(ray.origin_world_m.y());
      packet.origin_z[k] = static_cast<float>(ray.origin_world_m.z());
      packet.direction_x[k] = static_cast<float>(ray.direction_world.x());
      packet.direction_y[k] = static_cast<float>(ray.direction_world.y());
      packet.direction_z[k] = static_cast<float>(ray.direction_world.z());
      packet.far_m[k] = 60;
      packet.active[k] = k == 5 ? 0 : -1;
    }
    HitPacket hits;
    Blocked blocked;
    scene.cast(Eigen::Vector3d::Zero(), packet, hits);
    scene.occluded(Eigen::Vector3d::Zero(), packet, blocked);
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      if (k == 5) {
        EXPECT_EQ(hits.label[k], 0u);
        EXPECT_EQ(blocked[k], 0);
        continue;
      }
      const RayHit exact = scene.cast(rays[first + k], 60);
      EXPECT_EQ(hits.piece[k] != 0, hits.label[k] == 2);
      const bool same = exact.label == hits.label[k] &&
                        (exact.label == 0 || std::abs(exact.distance_m - double{hits.distance_m[k]}) < 1e-3);
      if (!same || (blocked[k] != 0) != (exact.label != 0)) ++other;
    }
  }
  EXPECT_LE(other, 4);
}

TEST_P(CoverInWater, DistancesIncludePieces) {
  const RayScene solids(with_solids(world, sway.get()));
  std::vector<Eigen::Vector3d> points;
  for (const Ray& ray : rays_from_above(300)) points.push_back(ray.origin_world_m);
  std::vector<double> found(points.size()), expected(points.size());
  cover.distance(points, found, 2);
  solids.distance(points, expected);
  for (std::size_t k = 0; k < points.size(); ++k) EXPECT_NEAR(found[k], expected[k], 1e-6);
}

TEST(Cover, ReleasedTilesReturnAsTheyWere) {
  const World world = bed_with_boxes(5);
  const RayDevice device = make_ray_device();
  const CoverTrees small(device.get(), world, 2000), large(device.get(), world);
  const std::vector<Ray> rays = rays_from_above(16 * 200);
  const auto cast = [&](const CoverTrees& trees, std::size_t first) {
    ExactRays packet;
    ExactHits hits;
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      set_ray(packet, k, rays[first + k].origin_world_m, rays[first + k].direction_world, 60, true);
    }
    set_all_missed(hits);
    trees.cast({&packet, 1}, nullptr, {&hits, 1});
    return hits.distance_m;
  };
  std::vector<std::jthread> threads;
  std::vector<int> wrong(4, 0);
  for (std::size_t t = 0; t < wrong.size(); ++t) {
    threads.emplace_back([&, t] {
      for (std::size_t first = 16 * t; first < rays.size(); first += 16 * wrong.size()) {
        if (cast(small, first) != cast(large, first)) ++wrong[t];
      }
    });
  }
  threads.clear();
  for (const int count : wrong) EXPECT_EQ(count, 0);
  EXPECT_GT(large.pieces_in_memory(), 10'000u);
  EXPECT_LE(small.pieces_in_memory(), 2000u);
}

TEST(Cover, RaysEnterABoxAtItsNearestSideWithEveryInstructionSet) {
  using Lanes = std::array<double, kPacketRays>;
  std::vector<const RayKernels*> all = {&baseline_ray_kernels()};
  if (processor_has(InstructionSet::avx2)) all.push_back(&avx2_ray_kernels());
  if (processor_has(InstructionSet::avx512)) all.push_back(&avx512_ray_kernels());
  constexpr double kNone = std::numeric_limits<double>::infinity();
  const Eigen::AlignedBox3d box(Eigen::Vector3d(-1, -2, -0.5), Eigen::Vector3d(1, 0.5, 0.5));
  const RandomStream random(3, "boxes");
  int met = 0, missed = 0;
  for (std::uint64_t tick = 0; tick < 300; ++tick) {
    Lanes origin[3], inverse[3], near_m, far_m, expected;
    std::array<std::int32_t, kPacketRays> active;
    double least = kNone;
    for (std::uint32_t k = 0; k < kPacketRays; ++k) {
      Eigen::Vector3d from, along;
      for (std::uint32_t axis = 0; axis < 3; ++axis) {
        from[axis] = 6 * random.uniform(tick, 8 * k + axis) - 3, along[axis] = random.normal(tick, 8 * k + 3 + axis);
      }
      if (k % 4 == 1) along[2] = 0;             // parallel to two sides
      if (k % 4 == 1 && k > 8) from.z() = 0.5;  // and in the plane of one of them
      if (k == 2) from = box.center();          // from inside
      along.normalize();
      near_m[k] = 0, far_m[k] = k % 5 == 0 ? 1 : 60, active[k] = k == 7 ? 0 : -1;
      double first = near_m[k], last = far_m[k];
      for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<std::size_t>(axis);
        origin[a][k] = from[axis], inverse[a][k] = 1 / along[axis];
        const double one = (box.min()[axis] - from[axis]) * inverse[a][k];
        const double two = (box.max()[axis] - from[axis]) * inverse[a][k];
        if (std::isnan(one) || std::isnan(two)) continue;  // the plane of a side belongs to the box
        first = std::max(first, std::min(one, two)), last = std::min(last, std::max(one, two));
      }
      expected[k] = active[k] != 0 && first <= last ? first : kNone;
      least = std::min(least, expected[k]);
      if (expected[k] == kNone) {
        ++missed;
        continue;
      }
      ++met;
      EXPECT_LT(box.exteriorDistance(Eigen::Vector3d(from + expected[k] * along)), 1e-12);
    }
    const LaneSlabs rays{{origin[0].data(), origin[1].data(), origin[2].data()},
                         {inverse[0].data(), inverse[1].data(), inverse[2].data()},
                         near_m.data(),
                         far_m.data(),
                         active.data()};
    for (const RayKernels* kernels : all) {
      Lanes first_m;
      EXPECT_EQ(kernels->enter_box(rays, box.min().data(), box.max().data(), first_m.data()), least);
      EXPECT_EQ(first_m, expected);
    }
  }
  EXPECT_GT(met, 500);
  EXPECT_GT(missed, 500);
}

TEST(Cover, LayersKeepToTheirConditions) {
  World world = bed_with_boxes();
  TriangleMesh wall = testing::box(1, 20, 6);
  for (Eigen::Vector3d& v : wall.vertices_m) v.z() -= kDepth_m;
  World walled;
  walled.set_terrain(*world.terrain());
  walled.add_solid("wall", wall);
  CoverLayer layer = *world.cover()[0];
  layer.name = "near";
  layer.density_per_m2 = 10;
  layer.from_solids_m = {0.1, 2};
  walled.add_cover(layer);
  layer.name = "deep";
  layer.depth_m = {kDepth_m + 0.1, 100};
  walled.add_cover(layer);
  layer = *world.cover()[0];
  layer.name = "patches";
  layer.density_per_m2 = 2;
  layer.patch_m = 4;
  layer.patch_share = 0.3;
  walled.add_cover(layer);
  std::array<int, 3> found{};
  for (const PlacedPiece& piece : RayScene(walled).cover_in({Eigen::Vector2d(-30, -30), Eigen::Vector2d(30, 30)})) {
    ++found[piece.label - 3u];
    EXPECT_DOUBLE_EQ(piece.position_world_m.z(), -kDepth_m);
    EXPECT_TRUE(piece.size_m >= 0.2 - 1e-6 && piece.size_m <= 1 + 1e-6);
    if (piece.label != 3) continue;
    EXPECT_GT(std::hypot(std::max(0.0, std::abs(piece.position_world_m.x()) - 0.5),
                         std::max(0.0, std::abs(piece.position_world_m.y()) - 10)),
              0.09);
    EXPECT_LT(std::abs(piece.position_world_m.x()), 2.51);
  }
  EXPECT_NEAR(found[0], 10 * (2 * 1.9 * 20 + 2 * 1.9 * 1 + 12), 200);
  EXPECT_EQ(found[1], 0);
  EXPECT_NEAR(found[2], 0.3 * 2 * 3600, 500);
}

TEST(Cover, BadLayersAreRefused) {
  const World world = bed_with_boxes();
  CoverLayer layer = *world.cover()[0];
  const auto refused = [&](auto change) {
    World other;
    other.set_terrain(*world.terrain());
    CoverLayer bad = layer;
    change(bad);
    EXPECT_THROW(other.add_cover(bad), InvalidValue);
  };
  refused([](CoverLayer& bad) { bad.density_per_m2 = -1; });
  refused([](CoverLayer& bad) { bad.density_per_m2 = std::nan(""); });
  refused([](CoverLayer& bad) { bad.size_m = {1, 0.5}; });
  refused([](CoverLayer& bad) { bad.size_m = {1e-60, 1}; });
  refused([](CoverLayer& bad) { bad.depth_m = {2, 1}; });
  refused([](CoverLayer& bad) { bad.meshes.clear(); });
  refused([](CoverLayer& bad) { bad.patch_share = 0; });
  refused([](CoverLayer& bad) { bad.name = "terrain"; });
  World dry;
  EXPECT_THROW(dry.add_cover(layer), InvalidValue);
  World covered = world;
  EXPECT_THROW(covered.add_solid("late", testing::box(1, 1, 1)), InvalidValue);
}

}  // namespace
}  // namespace uwsim
