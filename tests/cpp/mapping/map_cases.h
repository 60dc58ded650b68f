#pragma once

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <string>
#include <vector>

#include "uwsim/mapping/occupancy_map.h"

/// Small random maps, identical in both engines.
namespace uwsim {

inline constexpr double kNoLimit = std::numeric_limits<double>::infinity();
inline constexpr MapEngineKind kEngines[] = {MapEngineKind::octomap, MapEngineKind::bricks};

inline MapOptions with_engine(MapEngineKind engine) {
  MapOptions options;
  options.engine = engine;
  return options;
}

inline std::vector<float> random_points(std::mt19937& random, int count, double spread_m,
                                        const Eigen::Vector3d& about_m = Eigen::Vector3d::Zero()) {
  std::uniform_real_distribution<double> uniform(-spread_m, spread_m);
  std::vector<float> points_m;
  for (int i = 0; i < 3 * count; ++i) points_m.push_back(static_cast<float>(about_m[i % 3] + uniform(random)));
  return points_m;
}

/// Inserts a few scans near the map's origin, shifted by `offset_m`. The same seed produces the same scans.
inline void insert_some(OccupancyMap& map, unsigned seed, int scans, double spread_m,
                        const Eigen::Vector3d& offset_m = Eigen::Vector3d::Zero()) {
  std::mt19937 random(seed);
  const Eigen::Vector3d about_m = map.origin_world_m() + offset_m;
  for (int i = 0; i < scans; ++i) {
    const std::vector<float> points_m = random_points(random, 40, spread_m, about_m);
    const int repeats = 1 + static_cast<int>(random() % 6);  // some voxels reach the clamping limits
    for (int k = 0; k < repeats; ++k) map.insert_scan(points_m, about_m + Eigen::Vector3d(0.3 * i, 0.2, 0.1), kNoLimit);
  }
}

inline void expect_same_bytes(const OccupancyMap& a, const OccupancyMap& b) {
  EXPECT_TRUE(a.to_bytes(MapFormat::ot) == b.to_bytes(MapFormat::ot));
  EXPECT_TRUE(a.to_bytes(MapFormat::bt) == b.to_bytes(MapFormat::bt));
}

}  // namespace uwsim
