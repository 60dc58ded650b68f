// A map with a memory limit has the same bytes as the map without one.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "mapping/map_cases.h"
#include "uwsim/core/check.h"

namespace uwsim {
namespace {

using Eigen::Vector3d;

constexpr double kVoxel_m = 0.2;
constexpr int kPoints = 12;

MapOptions with_limit(std::size_t bytes) {
  MapOptions options;
  options.memory_limit_bytes = bytes;
  return options;
}

OccupancyMap map_of(const MapOptions& options = {}) { return OccupancyMap(kVoxel_m, Vector3d::Zero(), options); }

/// Inserts scans, three at a time, along a line, back and forth.
void fly(OccupancyMap& map, int legs, int threads) {
  std::mt19937 random(8);
  for (int leg = 0; leg < legs; ++leg) {
    for (int step = 0; step < 20; ++step) {
      const double x_m = 6.0 * (leg % 2 ? 20 - step : step);
      std::vector<float> points_m;
      std::vector<std::int64_t> counts;
      std::vector<double> origins_m;
      for (int scan = 0; scan < 3; ++scan) {
        const Vector3d origin_m(x_m + scan, 2.0 * leg, -3);
        const std::vector<float> points = random_points(random, kPoints, 12, origin_m - Vector3d(0, 0, 8));
        points_m.insert(points_m.end(), points.begin(), points.end());
        counts.push_back(kPoints);
        origins_m.insert(origins_m.end(), origin_m.begin(), origin_m.end());
      }
      map.insert_scans(points_m, counts, origins_m, 15, threads);
    }
  }
}

std::string file_bytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream bytes;
  bytes << file.rdbuf();
  return bytes.str();
}

TEST(MapSpill, BytesDoNotDependOnTheLimit) {
  OccupancyMap unlimited = map_of();
  fly(unlimited, 6, 1);
  for (const std::size_t limit : std::initializer_list<std::size_t>{1, 200'000, 1'000'000}) {
    for (const int threads : {1, 2}) {
      if (limit == 1 && threads == 2) continue;
      OccupancyMap limited = map_of(with_limit(limit));
      fly(limited, 6, threads);
      EXPECT_GT(limited.statistics().evictions, limit == 1 ? 1000u : 10u) << limit;
      expect_same_bytes(unlimited, limited);
      EXPECT_EQ(unlimited.statistics().nodes, limited.statistics().nodes);
      EXPECT_EQ(unlimited.statistics().free_voxels, limited.statistics().free_voxels);
    }
  }
}

TEST(MapSpill, FilesWrittenPieceByPieceHaveTheSameBytes) {
  OccupancyMap unlimited = map_of(), limited = map_of(with_limit(200'000));
  for (OccupancyMap* map : {&unlimited, &limited}) fly(*map, 3, 1);
  for (const MapFormat format : {MapFormat::bt, MapFormat::ot}) {
    for (const OccupancyMap* map : {&unlimited, &limited}) {
      const std::string path = testing::TempDir() + (format == MapFormat::bt ? "spill.bt" : "spill.ot");
      map->write(path, format);
      EXPECT_TRUE(file_bytes(path) == unlimited.to_bytes(format));
      std::filesystem::remove(path);
    }
  }
}

TEST(MapSpill, QueriesSeeTheEvictedParts) {
  OccupancyMap unlimited = map_of(), limited = map_of(with_limit(100'000));
  for (OccupancyMap* map : {&unlimited, &limited}) {
    fly(*map, 3, 1);
    map->changed_voxels();
  }
  const Vector3d all = Vector3d::Constant(1e6);
  const MapCubes voxels = unlimited.voxels_in(-all, all);
  EXPECT_EQ(limited.voxels_in(-all, all).log_odds, voxels.log_odds);
  std::mt19937 random(4);
  std::vector<double> points_m, directions;
  for (const float x : random_points(random, 3000, 60, {60, 0, -8})) points_m.push_back(x);
  for (const float x : random_points(random, 3000, 1)) directions.push_back(x);
  EXPECT_EQ(limited.state_at(points_m), unlimited.state_at(points_m));
  EXPECT_EQ(limited.cast_rays(points_m, directions, true, 30).ends,
            unlimited.cast_rays(points_m, directions, true, 30).ends);
  EXPECT_EQ(limited.cells(12).log_odds, unlimited.cells(12).log_odds);
  EXPECT_EQ(limited.leaves().edges_m, unlimited.leaves().edges_m);
  for (OccupancyMap* map : {&unlimited, &limited}) {
    map->set_model({0.8, 0.3, 0.2, 0.9});
    insert_some(*map, 3, 3, 10, {30, 0, -5});
  }
  EXPECT_EQ(limited.changed_voxels().voxel_centres_world_m, unlimited.changed_voxels().voxel_centres_world_m);
  OccupancyMap other = map_of(), other_limited = map_of(with_limit(50'000));
  for (OccupancyMap* map : {&other, &other_limited}) fly(*map, 1, 1);
  unlimited.merge(other);
  limited.merge(other_limited);
  expect_same_bytes(unlimited, limited);
}

TEST(MapSpill, FilesAreReadWithinTheLimit) {
  OccupancyMap unlimited = map_of();
  fly(unlimited, 3, 1);
  for (const MapFormat format : {MapFormat::bt, MapFormat::ot}) {
    const std::string bytes = unlimited.to_bytes(format);
    const OccupancyMap limited = OccupancyMap::from_bytes(bytes, "x", Vector3d::Zero(), with_limit(100'000));
    EXPECT_GT(limited.statistics().evictions, 10u);
    EXPECT_TRUE(limited.to_bytes(format) == bytes);
  }
}

/// Limits the size of files that this process writes, for the lifetime of the object.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) {
    std::signal(SIGXFSZ, SIG_IGN);
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() { ::setrlimit(RLIMIT_FSIZE, &before_); }

 private:
  rlimit before_;
};

TEST(MapSpill, FullDiskLeavesTheMapWhole) {
  OccupancyMap unlimited = map_of(), limited = map_of(with_limit(200'000));
  const auto insert = [&](OccupancyMap& map, double x_m) {
    std::mt19937 random(static_cast<unsigned>(x_m));
    map.insert_scan(random_points(random, 200, 12, {x_m, 0, -8}), {x_m, 0, 0}, 15);
  };
  int refused = 0;
  {
    const FileSizeLimit full(400'000);
    for (double x_m = 0; x_m < 200; x_m += 5) {
      try {
        insert(limited, x_m);
        insert(unlimited, x_m);
      } catch (const FileError& error) {
        ++refused;
        EXPECT_NE(std::string(error.what()).find("File too large; the map is whole"), std::string::npos);
      }
    }
    EXPECT_GT(refused, 3);
    EXPECT_LT(refused, 40);
  }
  expect_same_bytes(unlimited, limited);
  insert(limited, 7);  // files may grow again
  insert(unlimited, 7);
  expect_same_bytes(unlimited, limited);
}

TEST(MapSpill, NothingIsLeftInItsFolder) {
  const std::string folder = testing::TempDir() + "spill_here";
  std::filesystem::create_directory(folder);
  MapOptions options = with_limit(1);
  options.spill_folder = folder;
  OccupancyMap map = map_of(options);
  fly(map, 1, 1);
  EXPECT_GT(map.statistics().evictions, 10u);
  EXPECT_TRUE(std::filesystem::is_empty(folder));
  std::filesystem::remove(folder);
  EXPECT_THROW(map_of(options), FileError);
}

TEST(MapSpill, OnlyTheBrickEngineTakesALimit) {
  MapOptions options = with_limit(1'000'000);
  options.engine = MapEngineKind::octomap;
  EXPECT_THROW(map_of(options), InvalidValue);
}

}  // namespace
}  // namespace uwsim
