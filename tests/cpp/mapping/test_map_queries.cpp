// Queries of both engines return the same results as OctoMap.
#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <set>
#include <sstream>

#include "mapping/map_cases.h"
#include "uwsim/core/check.h"

extern template class octomap::OcTreeBaseImpl<octomap::OcTreeNode, octomap::AbstractOccupancyOcTree>;
extern template class octomap::OccupancyOcTreeBase<octomap::OcTreeNode>;

namespace uwsim {
namespace {

using Eigen::Vector3d;

const Vector3d kOrigin_m(100, -20, 3);

OccupancyMap some_map(MapEngineKind engine, unsigned seed, double edge_m = 0.5) {
  OccupancyMap map(edge_m, kOrigin_m, with_engine(engine));
  insert_some(map, seed, 5, 9);
  return map;
}

octomap::point3d in_tree(const double* world_m) {
  const Vector3d at = Vector3d(world_m) - kOrigin_m;
  return {static_cast<float>(at.x()), static_cast<float>(at.y()), static_cast<float>(at.z())};
}

void expect_equal(const MapCubes& a, const MapCubes& b) {
  EXPECT_EQ(a.centres_world_m, b.centres_world_m);
  EXPECT_EQ(a.edges_m, b.edges_m);
  EXPECT_EQ(a.log_odds, b.log_odds);
}

TEST(MapQueries, RaysEndWhereOctomapsRaysEnd) {
  for (unsigned seed = 0; seed < 6; ++seed) {
    const double edge_m = seed % 2 ? 0.3 : 0.5;
    const OccupancyMap octomap = some_map(kEngines[0], seed, edge_m), bricks = some_map(kEngines[1], seed, edge_m);
    const std::shared_ptr<octomap::OcTree> tree = octomap.octree();
    std::mt19937 random(seed);
    std::vector<double> origins_m, directions;
    for (const float x : random_points(random, 1500, 5, kOrigin_m)) origins_m.push_back(x);
    for (const float x : random_points(random, 1500, 1)) directions.push_back(x);
    for (std::size_t i = 0; i < 300; ++i) {  // along axes, and from corners of voxels
      directions[i] = i % 3 == 0 ? (i % 2 ? 1 : -1) : 0;
      if (i < 150) origins_m[i] = kOrigin_m[Eigen::Index(i % 3)] + edge_m * std::round(5 * directions[i]);
    }
    for (std::size_t i = 300; i < 1200; ++i) {  // from centres along diagonals: ties at every step
      const int axis = static_cast<int>(i % 3), ray = static_cast<int>(i / 3);
      origins_m[i] = kOrigin_m[axis] + edge_m * (0.5 + std::floor((origins_m[i] - kOrigin_m[axis]) / edge_m));
      directions[i] = ray % 4 == axis ? 0 : (ray >> axis & 4 ? 1 : -1);
    }
    for (std::size_t i = 0; i < directions.size(); i += 3) {
      if (directions[i] == 0 && directions[i + 1] == 0 && directions[i + 2] == 0) directions[i + 1] = 1;
    }
    int ends[3] = {};
    for (const bool ignore_unknown : {false, true}) {
      for (const double range_m : {2.0, 20.0}) {
        const auto cast = octomap.cast_rays(origins_m, directions, ignore_unknown, range_m);
        const auto ours = bricks.cast_rays(origins_m, directions, ignore_unknown, range_m);
        ASSERT_EQ(cast.ends, ours.ends);
        ASSERT_EQ(cast.voxel_centres_world_m, ours.voxel_centres_world_m);
        for (std::size_t i = 0; i < cast.ends.size(); ++i) {
          const octomap::point3d direction(static_cast<float>(directions[3 * i]),
                                           static_cast<float>(directions[3 * i + 1]),
                                           static_cast<float>(directions[3 * i + 2]));
          octomap::point3d end;
          const bool hit = tree->castRay(in_tree(&origins_m[3 * i]), direction, end, ignore_unknown, range_m);
          ASSERT_EQ(cast.ends[i] == 1, hit) << "ray " << i;
          const octomap::point3d got = in_tree(&cast.voxel_centres_world_m[3 * i]);
          ASSERT_NEAR((end - got).norm(), 0, 1e-4) << "ray " << i;
          ++ends[cast.ends[i] + 1];
        }
      }
    }
    for (const int count : ends) EXPECT_GT(count, 10);
  }
}

TEST(MapQueries, RaysThatCannotBeCastAreRefused) {
  const OccupancyMap map = some_map(kEngines[1], 1);
  const std::vector<double> origin_m{100, -20, 3}, up{0, 0, 1};
  const auto refuse = [&](std::vector<double> from_m, std::vector<double> direction, double range_m) {
    EXPECT_THROW(map.cast_rays(from_m, direction, false, range_m), InvalidValue);
  };
  refuse(origin_m, {0, 0, 0}, 5);
  refuse(origin_m, {std::nan(""), 0, 0}, 5);
  refuse({1e9, 0, 0}, up, 5);
  refuse(origin_m, up, 0);
  refuse(origin_m, up, std::nan(""));
  refuse(origin_m, {}, 5);
  const auto to_the_edge = map.cast_rays(origin_m, up, true, kNoLimit);  // this ray can be cast
  EXPECT_EQ(to_the_edge.ends.size(), 1u);
}

TEST(MapQueries, CellsAreOctomapsInnerNodes) {
  for (unsigned seed = 0; seed < 4; ++seed) {
    const OccupancyMap octomap = some_map(kEngines[0], seed), bricks = some_map(kEngines[1], seed);
    const std::shared_ptr<octomap::OcTree> tree = octomap.octree();
    for (int depth = 1; depth <= 16; ++depth) {
      const MapCubes cells = bricks.cells(depth);
      expect_equal(octomap.cells(depth), cells);
      ASSERT_GT(cells.log_odds.size(), 0u);
      double known_m3 = 0;
      for (std::size_t i = 0; i < cells.log_odds.size(); ++i) {
        const octomap::OcTreeNode* node =
            tree->search(tree->coordToKey(in_tree(&cells.centres_world_m[3 * i])), static_cast<unsigned>(depth));
        ASSERT_TRUE(node);
        ASSERT_EQ(node->getLogOdds(), cells.log_odds[i]) << "depth " << depth;
        known_m3 += std::pow(cells.edges_m[i], 3);
      }
      if (depth == 16) {
        const MapStatistics all = bricks.statistics();
        EXPECT_NEAR(known_m3, static_cast<double>(all.free_voxels + all.occupied_voxels) * 0.125, 1e-6);
      }
    }
    EXPECT_THROW(bricks.cells(0), InvalidValue);
    EXPECT_THROW(bricks.cells(17), InvalidValue);
  }
}

/// The leaves of the .ot that OctoMap writes: log-odds by centre and edge length.
class WrittenLeaves {
 public:
  explicit WrittenLeaves(const octomap::OcTree& tree) : edge_m_(tree.getResolution()) {
    std::ostringstream bytes;
    tree.writeData(bytes);
    bytes_ = bytes.str();
    node(Vector3d::Zero(), 65536);
  }

  std::map<std::vector<double>, float> leaves;

 private:
  void node(const Vector3d& corner, int voxels) {
    float log_odds;
    std::memcpy(&log_odds, &bytes_[at_], 4);
    const auto flags = static_cast<unsigned char>(bytes_[at_ + 4]);
    at_ += 5;
    if (flags == 0) {
      const Vector3d centre_m = (corner.array() - 32768 + 0.5 * voxels) * edge_m_;
      leaves[{centre_m.x(), centre_m.y(), centre_m.z(), voxels * edge_m_}] = log_odds;
    }
    for (int child = 0; child < 8; ++child) {
      if (flags >> child & 1) node(corner + Vector3d(child & 1, child >> 1 & 1, child >> 2) * voxels / 2, voxels / 2);
    }
  }

  double edge_m_;
  std::string bytes_;
  std::size_t at_ = 0;
};

TEST(MapQueries, LeavesAreThoseOfOctomapsPrunedTree) {
  for (unsigned seed = 0; seed < 4; ++seed) {
    const OccupancyMap octomap = some_map(kEngines[0], seed), bricks = some_map(kEngines[1], seed);
    const std::map<std::vector<double>, float> expected = WrittenLeaves(*octomap.octree()).leaves;
    const MapCubes leaves = bricks.leaves();
    expect_equal(octomap.leaves(), leaves);
    ASSERT_EQ(leaves.log_odds.size(), expected.size());
    double largest_m = 0;
    for (std::size_t i = 0; i < leaves.log_odds.size(); ++i) {
      const Vector3d centre_m = Vector3d(&leaves.centres_world_m[3 * i]) - kOrigin_m;
      const auto found = expected.find({centre_m.x(), centre_m.y(), centre_m.z(), leaves.edges_m[i]});
      ASSERT_TRUE(found != expected.end()) << centre_m.transpose();
      ASSERT_EQ(found->second, leaves.log_odds[i]);
      largest_m = std::max(largest_m, leaves.edges_m[i]);
    }
    EXPECT_GE(largest_m, 1.0) << "nothing was pruned";
  }
}

TEST(MapQueries, BoxesHoldTheVoxelsWhoseCentresLieInThem) {
  for (unsigned seed = 0; seed < 6; ++seed) {
    const OccupancyMap octomap = some_map(kEngines[0], seed), bricks = some_map(kEngines[1], seed);
    const Vector3d all = Vector3d::Constant(1e6);
    const MapCubes everything = bricks.voxels_in(-all, all);
    EXPECT_EQ(everything.log_odds.size(), bricks.statistics().free_voxels + bricks.statistics().occupied_voxels);
    std::mt19937 random(seed);
    for (int box = 0; box < 40; ++box) {
      const std::vector<float> corners = random_points(random, 2, 10, kOrigin_m);
      Vector3d low, high;
      for (Eigen::Index i = 0; i < 3; ++i) {
        low[i] = std::min(corners[std::size_t(i)], corners[std::size_t(i) + 3]);
        high[i] = std::max(corners[std::size_t(i)], corners[std::size_t(i) + 3]);
        if (box % 4 == 0) low[i] = 0.25 + 0.5 * std::round(2 * low[i]);  // faces through voxel centres
        if (box % 4 == 0) high[i] = std::max(low[i], high[i]);
      }
      MapCubes expected;
      for (std::size_t i = 0; i < everything.log_odds.size(); ++i) {
        const Vector3d centre(&everything.centres_world_m[3 * i]);
        if ((centre.array() < low.array()).any() || (centre.array() > high.array()).any()) continue;
        expected.centres_world_m.insert(expected.centres_world_m.end(), centre.begin(), centre.end());
        expected.edges_m.push_back(0.5);
        expected.log_odds.push_back(everything.log_odds[i]);
      }
      expect_equal(bricks.voxels_in(low, high), expected);
      expect_equal(octomap.voxels_in(low, high), expected);
    }
    EXPECT_EQ(bricks.log_odds_at(everything.centres_world_m), everything.log_odds);
    EXPECT_EQ(octomap.log_odds_at(everything.centres_world_m), everything.log_odds);
    EXPECT_THROW(bricks.voxels_in({1, 0, 0}, {0, 1, 1}), InvalidValue);
  }
}

using States = std::map<std::vector<double>, int>;

States states_of(const OccupancyMap& map) {
  const Vector3d all = Vector3d::Constant(1e6);
  const MapCubes voxels = map.voxels_in(-all, all);
  States states;
  for (std::size_t i = 0; i < voxels.log_odds.size(); ++i) {
    const double* at = &voxels.centres_world_m[3 * i];
    states[{at[0], at[1], at[2]}] = is_occupied(voxels.log_odds[i]);
  }
  return states;
}

TEST(MapChanges, AreTheDifferencesSinceTheLastCall) {
  for (unsigned seed = 0; seed < 6; ++seed) {
    std::vector<OccupancyMap::Changes> reported[2];
    for (const MapEngineKind engine : kEngines) {
      OccupancyMap map = some_map(engine, seed);
      States before;
      for (int step = 0; step < 8; ++step) {
        const OccupancyMap::Changes changes = map.changed_voxels();
        const States now = states_of(map);
        States expected, got;
        for (const auto& [at, state] : now) {
          const auto old = before.find(at);
          if (old == before.end() || old->second != state) expected[at] = state;
        }
        for (std::size_t i = 0; i < changes.states.size(); ++i) {
          const double* at = &changes.voxel_centres_world_m[3 * i];
          got[{at[0], at[1], at[2]}] = changes.states[i];
        }
        EXPECT_EQ(got.size(), changes.states.size());  // no voxel occurs twice
        EXPECT_EQ(got, expected) << "step " << step;
        EXPECT_EQ(got.empty(), step == 4);
        before = now;
        reported[engine == MapEngineKind::bricks].push_back(changes);
        if (step == 2) {
          OccupancyMap other = some_map(engine, seed + 20);
          map.merge(other);
        } else if (step != 3) {
          insert_some(map, seed + 100 * unsigned(step), 1, 12);
        }
      }
    }
    for (std::size_t step = 0; step < reported[0].size(); ++step) {
      EXPECT_EQ(reported[0][step].voxel_centres_world_m, reported[1][step].voxel_centres_world_m);
      EXPECT_EQ(reported[0][step].states, reported[1][step].states);
    }
  }
}

TEST(OccupancyChanges, GiveTheOccupiedVoxelsWhateverElseIsAsked) {
  for (unsigned seed = 0; seed < 4; ++seed) {
    for (const MapEngineKind engine : kEngines) {
      OccupancyMap map = some_map(engine, seed);
      std::set<std::array<int, 3>> occupied;
      for (int step = 0; step < 8; ++step) {
        if (step % 3 == 1) map.changed_voxels();
        const OccupancyMap::OccupancyChanges changes = map.changed_occupancy();
        for (std::size_t i = 0; i < changes.occupied.size(); ++i) {
          const std::int16_t* at = &changes.cells[3 * i];
          const std::array<int, 3> cell{at[0], at[1], at[2]};
          EXPECT_TRUE(changes.occupied[i] ? occupied.insert(cell).second : occupied.erase(cell) == 1);
        }
        EXPECT_EQ(changes.occupied.empty(), step == 4);
        std::set<std::array<int, 3>> expected;
        for (const auto& [at, state] : states_of(map)) {
          const auto cell = [&, &at = at](std::size_t axis) {
            return static_cast<int>(std::floor((at[axis] - kOrigin_m[Eigen::Index(axis)]) / 0.5));
          };
          if (state == 1) expected.insert({cell(0), cell(1), cell(2)});
        }
        EXPECT_EQ(occupied, expected) << "step " << step;
        if (step == 2) {
          OccupancyMap other = some_map(engine, seed + 20);
          map.merge(other);
        } else if (step != 3) {
          insert_some(map, seed + 100 * unsigned(step), 1, 12);
        }
      }
    }
  }
}

TEST(MapOutside, PointsOutsideTheCubeAreRefusedOrCounted) {
  const Vector3d low(-1e5, 0, 0);
  const std::vector<float> points_m{101, -20, 3, 1e6f, 0, 0, 102, -19, 3, std::nanf(""), 0, 0};
  for (const MapEngineKind engine : kEngines) {
    MapOptions counting = with_engine(engine);
    counting.on_outside = OnOutside::count;
    OccupancyMap refusing(0.5, kOrigin_m, with_engine(engine)), counts(0.5, kOrigin_m, counting);
    EXPECT_THROW(refusing.insert_scan(points_m, kOrigin_m, 50), InvalidValue);
    EXPECT_EQ(refusing.statistics().nodes, 0u);
    counts.insert_scan(points_m, kOrigin_m, 50);
    EXPECT_EQ(counts.statistics().outside_points, 1u);
    EXPECT_EQ(counts.statistics().occupied_voxels, 2u);
    counts.insert_scan(points_m, low, 50);  // counts all its points, because the origin is outside
    EXPECT_EQ(counts.statistics().outside_points, 4u);
    EXPECT_EQ(counts.statistics().occupied_voxels, 2u);
    refusing.insert_scan(std::vector<float>{101, -20, 3, 102, -19, 3}, kOrigin_m, 50);
    expect_same_bytes(refusing, counts);
    EXPECT_THROW(counts.insert_scan(points_m, {std::nan(""), 0, 0}, 50), InvalidValue);
  }
}

}  // namespace
}  // namespace uwsim
