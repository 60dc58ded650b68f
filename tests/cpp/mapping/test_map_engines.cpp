// The two engines of OccupancyMap produce the same maps: from files, from scans of any width, and as an
// octomap::OcTree.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <octomap/OcTree.h>
#include <unistd.h>

#include <cmath>
#include <limits>
#include <new>
#include <sstream>
#include <thread>

#include "mapping/map_cases.h"
#include "uwsim/core/check.h"
#include "uwsim/mapping/bricks/uninitialised_vector.h"
#include "uwsim/mapping/quiet_stderr.h"

extern template class octomap::OcTreeBaseImpl<octomap::OcTreeNode, octomap::AbstractOccupancyOcTree>;
extern template class octomap::OccupancyOcTreeBase<octomap::OcTreeNode>;

namespace uwsim {
namespace {

using Eigen::Vector3d;

constexpr MapOptions kOctomap{MapEngineKind::octomap, {}, InstructionSet::best};
constexpr MapOptions kBricks{};

void expect_same(const OccupancyMap& octomap, const OccupancyMap& bricks) {
  expect_same_bytes(octomap, bricks);
  EXPECT_EQ(octomap.statistics().nodes, bricks.statistics().nodes);
  EXPECT_EQ(octomap.statistics().occupied_voxels, bricks.statistics().occupied_voxels);
  EXPECT_EQ(octomap.statistics().free_voxels, bricks.statistics().free_voxels);
}

std::string small_map_file(std::mt19937& random, MapFormat format) {
  OccupancyModel model;
  model.clamping_min = 0.05;  // differs from the limit of the map that reads the file
  OccupancyMap map(0.5, Vector3d::Zero(), {MapEngineKind::octomap, model, InstructionSet::best});
  const int scans = 1 + static_cast<int>(random() % 12);
  const std::vector<float> points_m = random_points(random, 30, 6);
  for (int i = 0; i < scans; ++i) map.insert_scan(points_m, {0.1 * i, 0.2, 0.3}, kNoLimit);
  return map.to_bytes(format);
}

TEST(MapEngines, ScansAfterAFileGiveTheSameMap) {
  std::mt19937 random(3);
  for (int i = 0; i < 60; ++i) {
    const std::string file = small_map_file(random, i % 2 ? MapFormat::bt : MapFormat::ot);
    OccupancyMap octomap = OccupancyMap::from_bytes(file, "x", Vector3d::Zero(), kOctomap);
    OccupancyMap bricks = OccupancyMap::from_bytes(file, "x", Vector3d::Zero(), kBricks);
    expect_same(octomap, bricks);
    for (int scan = 0; scan < 3; ++scan) {
      const std::vector<float> points_m = random_points(random, 30, 8);
      for (OccupancyMap* map : {&octomap, &bricks}) map->insert_scan(points_m, {0.5, 1, -0.2}, kNoLimit);
    }
    expect_same(octomap, bricks);
    EXPECT_EQ(octomap.occupied_voxels_world_m(), bricks.occupied_voxels_world_m());
    EXPECT_EQ(octomap.free_voxels_world_m(), bricks.free_voxels_world_m());
  }
}

TEST(MapEngines, ScansIntoLeavesOfAnySizeGiveTheSameMap) {
  const std::string eight_free = octree_header(MapFormat::bt, 9, 0.5) + "UU";
  const std::string one_occupied = octree_header(MapFormat::bt, 2, 0.5) + std::string("\x02\0", 2);
  // Inner nodes down to a leaf with an edge of 2^levels voxels in the first corner of the cube.
  const auto deep_leaf = [](int levels) {
    std::string body;
    for (int depth = 0; depth < 15 - levels; ++depth) body += std::string("\x03\0", 2);
    return octree_header(MapFormat::bt, static_cast<std::uint64_t>(17 - levels), 0.5) + body + std::string("\x01\0", 2);
  };
  std::vector<std::string> files{eight_free, one_occupied};
  for (int levels = 0; levels < 15; ++levels) files.push_back(deep_leaf(levels));
  const double corner_m = -16'383.4;
  std::mt19937 random(9);
  for (const std::string& file : files) {
    OccupancyMap octomap = OccupancyMap::from_bytes(file, "x", Vector3d::Zero(), kOctomap);
    OccupancyMap bricks = OccupancyMap::from_bytes(file, "x", Vector3d::Zero(), kBricks);
    expect_same(octomap, bricks);
    for (const Vector3d& origin_m : {Vector3d(0.1, 0.2, 0.3), Vector3d(corner_m + 20, corner_m + 20, corner_m + 20)}) {
      std::vector<float> points_m = random_points(random, 20, 15);
      for (std::size_t i = 0; i < points_m.size(); ++i) points_m[i] += static_cast<float>(origin_m[0]);
      for (OccupancyMap* map : {&octomap, &bricks}) map->insert_scan(points_m, origin_m, kNoLimit);
      expect_same(octomap, bricks);
      std::vector<double> where_m(points_m.begin(), points_m.end());
      EXPECT_EQ(octomap.state_at(where_m), bricks.state_at(where_m));
    }
  }
}

TEST(MapEngines, ScansTooWideForTheBitmapGiveTheSameMap) {
  std::mt19937 random(4);
  for (const double spread_m : {200.0, 1500.0}) {
    const std::vector<float> points_m = random_points(random, 4, spread_m);
    for (const InstructionSet set : {InstructionSet::portable, InstructionSet::best}) {
      OccupancyMap octomap(0.1, Vector3d::Zero(), kOctomap);
      OccupancyMap bricks(0.1, Vector3d::Zero(), {MapEngineKind::bricks, {}, set});
      for (OccupancyMap* map : {&octomap, &bricks}) {
        map->insert_scan(points_m, {1, -2, 3}, kNoLimit);
        map->insert_scan(points_m, {1, -2, 3}, 0.9 * spread_m);
      }
      expect_same(octomap, bricks);
    }
  }
}

TEST(MapEngines, LongestRayGivesTheSameMap) {
  OccupancyMap octomap(0.1, Vector3d::Zero(), kOctomap), bricks(0.1);
  const std::vector<float> point_m{3200, 500, 400};
  for (OccupancyMap* map : {&octomap, &bricks}) map->insert_scan(point_m, {-2200, -1000, -500}, kNoLimit);
  expect_same(octomap, bricks);
  EXPECT_GT(bricks.statistics().free_voxels, 70'000u);
}

TEST(MapEngines, BothGiveOctomapsTreeWithTheirBytes) {
  std::mt19937 random(5);
  const std::vector<float> points_m = random_points(random, 200, 10);
  for (const MapOptions& options : {kOctomap, kBricks}) {
    OccupancyMap map(0.25, Vector3d::Zero(), options);
    EXPECT_FALSE(map.bounds());
    map.insert_scan(points_m, {0, 0, 0}, kNoLimit);
    const std::shared_ptr<octomap::OcTree> tree = map.octree();
    EXPECT_EQ(tree->size(), map.statistics().nodes);
    std::ostringstream full;
    static_cast<octomap::AbstractOcTree&>(*tree).write(full);
    EXPECT_EQ(full.str(), map.to_bytes(MapFormat::ot));
    octomap::point3d hit;
    Vector3d low_m, high_m;
    tree->getMetricMin(low_m.x(), low_m.y(), low_m.z());
    tree->getMetricMax(high_m.x(), high_m.y(), high_m.z());
    EXPECT_NEAR((map.bounds()->low_world_m - low_m).norm(), 0, 1e-9);
    EXPECT_NEAR((map.bounds()->high_world_m - high_m).norm(), 0, 1e-9);
    ASSERT_TRUE(tree->castRay({0, 0, 0}, {points_m[0], points_m[1], points_m[2]}, hit, true));
    EXPECT_EQ(map.state_at(std::vector<double>{hit.x(), hit.y(), hit.z()})[0], 1);
  }
}

TEST(MapEngines, BatchIsInsertedWholeOrNotAtAll) {
  const double nan = std::nan("");
  const std::vector<float> points_m{1, 0, 0, 2, 0, 0, 3, 0, 0};
  const std::vector<double> origins_m{0, 0, 0, 0, 0, 1};
  for (const MapOptions& options : {kOctomap, kBricks}) {
    OccupancyMap map(0.5, Vector3d::Zero(), options);
    const auto refuse = [&](std::vector<std::int64_t> counts, std::vector<double> origins, double range_m,
                            int threads) {
      EXPECT_THROW(map.insert_scans(points_m, counts, origins, range_m, threads), InvalidValue);
    };
    refuse({1, 1}, origins_m, 5, 1);
    refuse({1, 3}, origins_m, 5, 1);
    refuse({4, -1}, origins_m, 5, 1);
    refuse({1}, origins_m, 5, 1);
    refuse({1, 2}, {0, 0, 0, 0, 0, nan}, 5, 1);
    refuse({1, 2}, {0, 0, 0, 0, 0, 1e9}, 5, 1);
    refuse({1, 2}, origins_m, 0, 1);
    refuse({1, 2}, origins_m, nan, 1);
    refuse({1, 2}, origins_m, 5, 0);
    EXPECT_EQ(map.statistics().nodes, 0u);
    map.insert_scans(points_m, std::vector<std::int64_t>{1, 2}, origins_m, kNoLimit, 3);
    EXPECT_EQ(map.statistics().occupied_voxels, 3u);
  }
}

TEST(MapEngines, ProbabilitiesOutOfRangeAreRefused) {
  const auto refuse = [](OccupancyModel model) {
    EXPECT_THROW(OccupancyMap(0.5, Vector3d::Zero(), {MapEngineKind::bricks, model, InstructionSet::best}),
                 InvalidValue);
  };
  const double nan = std::nan("");
  for (const double bad : {0.0, 1.0, -1.0, nan}) {
    refuse({bad, 0.4, 0.1, 0.9});
    refuse({0.7, bad, 0.1, 0.9});
    refuse({0.7, 0.4, bad, 0.9});
    refuse({0.7, 0.4, 0.1, bad});
  }
  refuse({0.4, 0.4, 0.1, 0.9});
  refuse({0.7, 0.6, 0.1, 0.9});
  refuse({0.7, 0.4, 0.9, 0.1});
}

TEST(MapEngines, RaysToPointsAtFloatDistanceZeroEnd) {
  const float tiny = -1e-30f;
  const std::vector<float> points_m{tiny, tiny, tiny, tiny, 0, 0, 0, tiny, tiny};
  OccupancyMap octomap(0.5, Vector3d::Zero(), kOctomap), bricks(0.5);
  for (OccupancyMap* map : {&octomap, &bricks}) map->insert_scan(points_m, Vector3d::Zero(), kNoLimit);
  expect_same(octomap, bricks);
  EXPECT_EQ(bricks.statistics().occupied_voxels, 1u);
}

/// A failed reserve() must not count as available space: a smaller one after it would write past the end.
TEST(UninitialisedVector, ReservesAgainAfterThereWasNoMemory) {
  UninitialisedVector<double> vector;
  *vector.reserve(1) = 1.5;
  vector.extend(1);
  const std::size_t too_many = std::numeric_limits<std::size_t>::max() / 4;
  EXPECT_THROW(vector.reserve(too_many), std::bad_alloc);
  const double* const before = vector.data();
  EXPECT_NE(vector.reserve(1000), before + 1) << "reserved nothing, as if there had been space";
  EXPECT_EQ(vector.data()[0], 1.5);
}

TEST(QuietStderr, DropsTheTextOfItsThreadOnly) {
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  const int real_stderr = ::dup(STDERR_FILENO);
  ::dup2(ends[1], STDERR_FILENO);
  {
    const QuietStderr quiet;
    std::fprintf(stderr, "dropped\n");
    std::jthread([] { std::fprintf(stderr, "other thread\n"); }).join();
  }
  std::fprintf(stderr, "afterwards\n");
  ::dup2(real_stderr, STDERR_FILENO);
  ::close(ends[1]);
  char text[64] = {};
  ssize_t size = 0;
  for (ssize_t more; (more = ::read(ends[0], text + size, sizeof text - 1 - static_cast<std::size_t>(size))) > 0;) {
    size += more;
  }
  EXPECT_STREQ(text, "other thread\nafterwards\n");
}

}  // namespace
}  // namespace uwsim
