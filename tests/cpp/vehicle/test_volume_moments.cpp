#include "uwsim/vehicle/volume_moments.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>
#include <vector>

#include "meshes.h"
#include "uwsim/core/instruction_set.h"
#include "uwsim/core/random.h"
#include "uwsim/vehicle/cut_kernels.h"

namespace uwsim {
namespace {

/// An asymmetric egg with 2,024 triangles.
TriangleMesh egg() {
  TriangleMesh mesh = testing::sphere(1, 23);
  for (Eigen::Vector3d& v : mesh.vertices_m)
    v = Eigen::Vector3d(0.3 * v.x(), 0.2 * v.y(), (0.12 + 0.03 * v.x()) * v.z());
  return mesh;
}

/// Reference: moments of the wet part of the mesh about the origin, triangle by triangle. Each triangle is clipped
/// corner by corner (Sutherland and Hodgman 1974), and the cut face is a fan from some point of the plane.
VolumeMoments clipped(const TriangleMesh& mesh, const Eigen::Vector3d& up, double level_m) {
  VolumeMoments sum;
  const auto add = [&sum](const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
    const double volume_m3 = a.dot(b.cross(c)) / 6;
    const Eigen::Vector3d all = a + b + c;
    sum.volume_m3 += volume_m3;
    sum.first_m4 += volume_m3 / 4 * all;
    sum.second_m5 +=
        volume_m3 / 20 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + all * all.transpose());
  };
  const Eigen::Vector3d on_plane = level_m * up + 0.1 * up.unitOrthogonal();
  for (const Triangle& t : mesh.triangles) {
    std::vector<Eigen::Vector3d> wet;
    Eigen::Vector3d leaves = on_plane, enters = on_plane;  // where its outline leaves and enters the water
    for (std::size_t k = 0; k < 3; ++k) {
      const Eigen::Vector3d &a = mesh.vertices_m[t[k]], &b = mesh.vertices_m[t[(k + 1) % 3]];
      const double h = up.dot(a) - level_m, g = up.dot(b) - level_m;
      if (h < 0) wet.push_back(a);
      if ((h < 0) == (g < 0)) continue;
      wet.push_back((h < 0 ? leaves : enters) = a + h / (h - g) * (b - a));
    }
    for (std::size_t k = 2; k < wet.size(); ++k) add(wet[0], wet[k - 1], wet[k]);
    add(on_plane, enters, leaves);
  }
  return sum;
}

void expect_same(const VolumeMoments& got, const VolumeMoments& expected, const VolumeMoments& scale) {
  EXPECT_NEAR(got.volume_m3, expected.volume_m3, 1e-12 * scale.volume_m3);
  EXPECT_LT((got.first_m4 - expected.first_m4).norm(), 1e-12 * scale.volume_m3);
  EXPECT_LT((got.second_m5 - expected.second_m5).norm(), 1e-12 * scale.second_m5.norm());
}

constexpr std::array kPitches = {1.0, 8.0};  // in still water and in waves

TEST(CutVolume, AtAnyTiltAndLevelItEqualsTheSumOfClippedTriangles) {
  const TriangleMesh mesh = egg();
  for (const double pitch : kPitches) {
    const CutVolume volume(mesh, pitch);
    for (int tilt = 0; tilt < 12; ++tilt) {
      const Eigen::Vector3d up =
          Eigen::AngleAxisd(0.5 * tilt, Eigen::Vector3d(1, 0.4 * tilt, 0.3).normalized()) * Eigen::Vector3d::UnitZ();
      for (const double level_m : {-0.2, -0.07, -0.001, 0.0, 0.03, 0.11, 0.4}) {
        expect_same(volume.below(up, level_m, true), clipped(mesh, up, level_m), volume.whole());
        EXPECT_EQ(volume.below(up, level_m, false).volume_m3, volume.below(up, level_m, true).volume_m3);
        EXPECT_EQ(volume.below(up, level_m, false).first_m4, volume.below(up, level_m, true).first_m4);
      }
    }
  }
}

TEST(CutVolume, APlaneAnywhereInItsCellEqualsTheSumOfClippedTriangles) {
  const TriangleMesh mesh = egg();
  for (const double pitch : kPitches) {
    const CutVolume volume(mesh, pitch);
    const RandomStream random(3, "planes");
    const double pitch_m = pitch * 0.3 / 128;  // pitch of cells in level
    for (std::uint64_t k = 0; k < 300; ++k) {
      const auto draw = [&](std::uint64_t index) { return 2 * random.uniform(k, index) - 1; };
      const Eigen::Vector3d up = Eigen::Vector3d(draw(0), draw(1), draw(2)).normalized();
      const double level_m = 0.15 * draw(3), edge_m = (std::floor(level_m / pitch_m) + 0.5) * pitch_m;
      for (const double at_m : {level_m, edge_m * (1 - 1e-15), edge_m, edge_m * (1 + 1e-15)})
        expect_same(volume.below(up, at_m, true), clipped(mesh, up, at_m), volume.whole());
    }
  }
}

TEST(CutVolume, TheFaceOfABoxIsItsSection) {
  const CutVolume volume(testing::box(1, 2, 0.5));
  const PlaneCut cut = volume.cut(Eigen::Vector3d::UnitZ(), 0.1);
  EXPECT_NEAR(cut.area_m2, 2, 1e-12);
  EXPECT_LT((cut.area_first_m3 - Eigen::Vector3d(0, 0, 0.2)).norm(), 1e-12);
  const Eigen::Vector3d second_m4(2.0 / 12, 8.0 / 12, 0.02);
  EXPECT_LT((cut.area_second_m4 - Eigen::Matrix3d(second_m4.asDiagonal())).norm(), 1e-12);
  expect_same(cut.below, volume.below(Eigen::Vector3d::UnitZ(), 0.1, true), volume.whole());
}

TEST(CutVolume, APlaneThatMovedIsFollowedToFirstOrder) {
  const CutVolume volume(egg(), 8);
  const double length_m = 0.3;
  const auto error = [&](double share) {  // of a plane that turns by share / 2 and rises by share * length / 4
    const Eigen::Vector3d up = Eigen::Vector3d(0.1, -0.2, 1).normalized(), axis = Eigen::Vector3d(2, 1, 0).normalized();
    const Eigen::Vector3d turned = Eigen::AngleAxisd(0.5 * share, axis) * up;
    const double level_m = 0.04, moved_m = level_m + 0.25 * share * length_m;
    const PlaneCut cut = volume.cut(up, level_m);
    EXPECT_EQ(cut.is_near(turned, moved_m, length_m), share < 0.01) << share;
    const VolumeMoments got = cut.moved_to(turned, moved_m), exact = volume.below(turned, moved_m, true);
    EXPECT_LT((got.second_m5 - exact.second_m5).norm(), 0.1 * share * exact.second_m5.norm());
    return std::max(std::abs(got.volume_m3 - exact.volume_m3) / exact.volume_m3,
                    (got.first_m4 - exact.first_m4).norm() / (exact.volume_m3 * length_m));
  };
  EXPECT_LT(error(0.005), 1e-4);
  for (const double share : {0.05, 0.005}) EXPECT_LT(error(share / 10), 0.02 * error(share));
}

TEST(CutVolume, WhatAThreadDidBeforeDoesNotChangeAResult) {
  const CutVolume volume(egg()), other(testing::sphere(0.2, 11));
  const Eigen::Vector3d up = Eigen::Vector3d(0.1, -0.2, 1).normalized();
  const VolumeMoments first = volume.below(up, 0.01, true);
  for (int k = 0; k < 40; ++k) {
    volume.below(Eigen::Vector3d(0.1, 0.01 * k, 1).normalized(), 0.02, false);
    other.below(up, 0.01, true);
    const VolumeMoments again = volume.below(up, 0.01, true);
    EXPECT_EQ(again.volume_m3, first.volume_m3);
    EXPECT_EQ(again.first_m4, first.first_m4);
    EXPECT_EQ(again.second_m5, first.second_m5);
  }
}

TEST(CutKernels, AllInstructionSetsGiveTheSameBits) {
  const RandomStream random(4, "triangles");
  std::vector<CutBlock> blocks(50);
  for (std::uint64_t n = 0; n < blocks.size(); ++n) {
    for (std::uint64_t k = 0; k < kCutLanes; ++k) {
      for (std::uint64_t c = 0; c < 9; ++c) blocks[n].corner_m[c][k] = random.uniform(n, 10 * k + c) - 0.5;
      const double higher_m = static_cast<double>(n % 3) - 1;  // below the plane, cut, or above it
      for (std::uint64_t c = 2; c < 9; c += 3) blocks[n].corner_m[c][k] += 2 * higher_m;
      blocks[n].volume_m3[k] = random.uniform(n, 10 * k + 9) - 0.5;
    }
  }
  const Eigen::Vector3d up = Eigen::Vector3d(0.2, -0.1, 1).normalized();
  const auto sums = [&](CutKernels::Add add) {
    CutSums out{};
    FaceSums out_face{};
    add(blocks.data(), blocks.size(), up.data(), 0.05, out, &out_face);
    return std::pair(out, out_face);
  };
  const auto same = [](const auto& a, const auto& b) {
    return std::memcmp(&a.first, &b.first, sizeof a.first) == 0 &&
           std::memcmp(&a.second, &b.second, sizeof a.second) == 0;
  };
  const CutKernels& baseline = baseline_cut_kernels();
  for (const auto& [set, kernels] : {std::pair{InstructionSet::avx2, &avx2_cut_kernels()},
                                     std::pair{InstructionSet::avx512, &avx512_cut_kernels()}}) {
    if (!processor_has(set)) continue;
    EXPECT_TRUE(same(sums(kernels->add), sums(baseline.add)));
    EXPECT_TRUE(same(sums(kernels->add_with_second), sums(baseline.add_with_second)));
    EXPECT_TRUE(same(sums(kernels->add_with_face), sums(baseline.add_with_face)));
  }
}

TEST(CutVolume, TheTwoSidesOfAPlaneAddUpToTheWhole) {
  for (const TriangleMesh& mesh : {egg(), testing::box(1, 2, 0.5)}) {
    const CutVolume volume(mesh);
    for (const Eigen::Vector3d& tilt : {Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(2, 1, 0), Eigen::Vector3d(1, 1, 5)}) {
      const Eigen::Vector3d up = tilt.normalized();
      for (const double level_m : {0.0, 0.1, 0.25}) {  // includes planes through vertices and along faces
        VolumeMoments both = volume.below(up, level_m, true);
        both += volume.below(-up, -level_m, true);
        expect_same(both, volume.whole(), volume.whole());
      }
    }
  }
}

}  // namespace
}  // namespace uwsim
