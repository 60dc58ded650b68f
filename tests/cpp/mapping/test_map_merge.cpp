// Compares merged maps, and maps with changed probabilities, with OctoMap's own tree voxel by voxel.
#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include <sstream>

#include "mapping/map_cases.h"
#include "uwsim/core/check.h"

extern template class octomap::OcTreeBaseImpl<octomap::OcTreeNode, octomap::AbstractOccupancyOcTree>;
extern template class octomap::OccupancyOcTreeBase<octomap::OcTreeNode>;

namespace uwsim {
namespace {

using Eigen::Vector3d;

constexpr double kEdge_m = 0.5;

OccupancyMap empty_map(MapEngineKind engine, const Vector3d& origin_m = Vector3d::Zero()) {
  return OccupancyMap(kEdge_m, origin_m, with_engine(engine));
}

/// The .ot of a copy of `map` to which OctoMap has added the log-odds of each known voxel of `other`.
std::string merged_by_octomap(const OccupancyMap& map, const OccupancyMap& other) {
  const std::shared_ptr<octomap::OcTree> tree = map.octree();
  const Vector3d far = Vector3d::Constant(1000);
  const MapCubes voxels = other.voxels_in(other.origin_world_m() - far, other.origin_world_m() + far);
  for (std::size_t i = 0; i < voxels.log_odds.size(); ++i) {
    const double* at = &voxels.centres_world_m[3 * i];
    const octomap::point3d centre(static_cast<float>(at[0]), static_cast<float>(at[1]), static_cast<float>(at[2]));
    tree->updateNode(tree->coordToKey(centre), voxels.log_odds[i]);
  }
  std::ostringstream bytes;
  static_cast<octomap::AbstractOcTree&>(*tree).write(bytes);
  return bytes.str();
}

TEST(MapMerge, GivesTheSumsThatOctomapGives) {
  for (unsigned seed = 0; seed < 12; ++seed) {
    for (const Vector3d& apart_m : {Vector3d(0, 0, 0), Vector3d(0.5, -1, 3.5), Vector3d(32, -32, 64)}) {
      for (const MapEngineKind engine : kEngines) {
        for (const MapEngineKind other_engine : kEngines) {
          OccupancyMap map = empty_map(engine), other = empty_map(other_engine, apart_m);
          insert_some(map, seed, 3, 6);
          insert_some(other, seed + 100, 3, 6, -0.5 * apart_m);
          const std::string expected = merged_by_octomap(map, other);
          map.merge(other);
          ASSERT_TRUE(map.to_bytes(MapFormat::ot) == expected) << "seed " << seed;
        }
      }
    }
  }
}

TEST(MapMerge, UnknownVoxelsTakeTheValuesOfTheOtherMap) {
  for (const MapEngineKind engine : kEngines) {
    OccupancyMap full = empty_map(engine), empty = empty_map(engine);
    insert_some(full, 3, 4, 7);
    const std::string before = full.to_bytes(MapFormat::ot);
    full.merge(empty);
    EXPECT_TRUE(full.to_bytes(MapFormat::ot) == before);
    empty.merge(full);
    EXPECT_TRUE(empty.to_bytes(MapFormat::ot) == before);
  }
}

TEST(MapMerge, OfLeavesOfAnySizeIsTheSameInBothEngines) {
  // Inner nodes down to a leaf with an edge of 2^levels voxels in the first corner of the cube, free (1) or occupied
  // (2).
  const auto deep_leaf = [](int levels, char code) {
    std::string body;
    for (int depth = 0; depth < 15 - levels; ++depth) body += std::string("\x03\0", 2);
    return octree_header(MapFormat::bt, static_cast<std::uint64_t>(17 - levels), kEdge_m) + body + code + '\0';
  };
  const auto read = [&](int levels, char code, MapEngineKind engine) {
    return OccupancyMap::from_bytes(deep_leaf(levels, code), "x", Vector3d::Zero(), with_engine(engine));
  };
  const Vector3d corner_m = Vector3d::Constant(-32768 * kEdge_m + 4);
  for (int first = 0; first < 15; ++first) {
    for (int second = 0; second < 15; ++second) {
      std::vector<OccupancyMap> merged;
      for (const MapEngineKind engine : kEngines) {
        merged.push_back(read(first, 1, engine));
        insert_some(merged.back(), 5, 2, 3, corner_m);
        merged.back().merge(read(second, 2, engine));
        insert_some(merged.back(), 6, 2, 3, corner_m);
      }
      expect_same_bytes(merged[0], merged[1]);
      EXPECT_EQ(merged[0].statistics().occupied_voxels, merged[1].statistics().occupied_voxels);
    }
  }
}

TEST(MapMerge, MapsOnAnotherGridAreRefused) {
  for (const MapEngineKind engine : kEngines) {
    OccupancyMap map = empty_map(engine);
    insert_some(map, 1, 2, 5);
    const std::string before = map.to_bytes(MapFormat::ot);
    OccupancyMap finer(0.25, Vector3d::Zero(), with_engine(engine));
    EXPECT_THROW(map.merge(finer), InvalidValue);
    EXPECT_THROW(map.merge(empty_map(engine, {0.1, 0, 0})), InvalidValue);
    EXPECT_THROW(map.merge(empty_map(engine, {1e9, 0, 0})), InvalidValue);
    EXPECT_THROW(map.merge(map), InvalidValue);
    OccupancyMap far = empty_map(engine, {16384, 0, 0});
    insert_some(far, 1, 2, 5);
    EXPECT_THROW(map.merge(far), InvalidValue);  // half of it lies outside
    EXPECT_TRUE(map.to_bytes(MapFormat::ot) == before);
  }
}

TEST(MapModel, ActsOnLaterScansOnlyAsInOctomap) {
  const OccupancyModel models[] = {{0.9, 0.2, 0.3, 0.8}, {0.7, 0.4, 0.05, 0.99}, {0.5, 0.5, 0.4, 0.6}, {}};
  for (unsigned seed = 0; seed < 8; ++seed) {
    OccupancyMap octomap = empty_map(kEngines[0]), bricks = empty_map(kEngines[1]);
    for (const OccupancyModel& model : models) {
      for (OccupancyMap* map : {&octomap, &bricks}) {
        insert_some(*map, seed, 3, 5);
        map->set_model(model);
      }
      expect_same_bytes(octomap, bricks);
      for (OccupancyMap* map : {&octomap, &bricks}) insert_some(*map, seed + 50, 3, 5, {1, 1, 0});
      expect_same_bytes(octomap, bricks);
    }
    EXPECT_EQ(bricks.model().hit, 0.7);
    EXPECT_THROW(bricks.set_model({0.7, 0.4, 0.9, 0.1}), InvalidValue);
    EXPECT_EQ(bricks.model().clamping_min, 0.1192);
  }
}

}  // namespace
}  // namespace uwsim
