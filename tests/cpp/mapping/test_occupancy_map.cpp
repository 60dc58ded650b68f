#include "uwsim/mapping/occupancy_map.h"

#include <gtest/gtest.h>
#include <octomap/OcTree.h>
#include <sys/resource.h>

#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <sstream>

#include "mapping/map_cases.h"
#include "uwsim/core/check.h"
#include "uwsim/mapping/atomic_file.h"

extern template class octomap::OcTreeBaseImpl<octomap::OcTreeNode, octomap::AbstractOccupancyOcTree>;
extern template class octomap::OccupancyOcTreeBase<octomap::OcTreeNode>;

namespace uwsim {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

/// A scan of a wavy floor 8 m below a sensor that moves along x.
std::vector<float> floor_scan(double x_m) {
  std::vector<float> points_m;
  for (int beam = 0; beam < 200; ++beam) {
    const double y_m = -10 + 0.1 * beam;
    points_m.insert(points_m.end(), {static_cast<float>(x_m + 8), static_cast<float>(y_m),
                                     static_cast<float>(-8 + std::sin(x_m / 3) * std::cos(y_m / 2))});
  }
  return points_m;
}

Vector3d sensor_at(double x_m) { return {x_m, 0.03, 0.01}; }

OccupancyMap floor_map(double resolution_m = 0.5, int scans = 40) {
  OccupancyMap map(resolution_m);
  for (int i = 0; i < scans; ++i) map.insert_scan(floor_scan(0.2 * i), sensor_at(0.2 * i), kNoLimit);
  return map;
}

std::string refusal_of(std::string_view bytes) {
  try {
    OccupancyMap::from_bytes(bytes, "x.bt");
  } catch (const InvalidValue& error) {
    return error.what();
  }
  return "";
}

std::string replaced(std::string text, const std::string& what, const std::string& with) {
  return text.replace(text.find(what), what.size(), with);
}

class Folder {
 public:
  Folder() : path(fs::temp_directory_path() / ("uwsim_map_" + std::to_string(::getpid()))) {
    fs::create_directory(path);
  }
  ~Folder() { fs::remove_all(path); }
  std::size_t files() const { return static_cast<std::size_t>(std::distance(fs::directory_iterator(path), {})); }
  const fs::path path;
};

TEST(OccupancyMap, RayMakesTheVoxelsItPassesFreeAndItsEndOccupied) {
  OccupancyMap map(0.1);
  map.insert_scan(std::vector<float>{10.02f, 0.05f, 0.05f}, {0.05, 0.05, 0.05}, kNoLimit);
  std::vector<double> passed_m;
  for (int i = 0; i < 100; ++i) passed_m.insert(passed_m.end(), {0.05 + 0.1 * i, 0.05, 0.05});
  EXPECT_EQ(map.state_at(passed_m), std::vector<std::int8_t>(100, 0));
  EXPECT_EQ(map.state_at(std::vector<double>{10.05, 0.05, 0.05, 10.15, 0.05, 0.05, 5, 0.15, 0.05, 1e9, 0, 0}),
            (std::vector<std::int8_t>{1, -1, -1, -1}));
  EXPECT_EQ(map.statistics().occupied_voxels, 1u);
  EXPECT_EQ(map.statistics().free_voxels, 100u);
}

TEST(OccupancyMap, PointBeyondMaxRangeOnlyMakesVoxelsUpToThereFree) {
  OccupancyMap map(0.1);
  map.insert_scan(std::vector<float>{10.05f, 0.05f, 0.05f}, {0.05, 0.05, 0.05}, 5.0);
  EXPECT_EQ(map.statistics().occupied_voxels, 0u);
  EXPECT_EQ(map.state_at(std::vector<double>{4.95, 0.05, 0.05, 5.25, 0.05, 0.05}), (std::vector<std::int8_t>{0, -1}));
}

TEST(OccupancyMap, FilesHaveTheBytesThatOctomapWrites) {
  octomap::OcTree stock(0.5);
  for (int i = 0; i < 40; ++i) {
    const std::vector<float> points_m = floor_scan(0.2 * i);
    octomap::Pointcloud cloud;
    for (std::size_t k = 0; k < points_m.size(); k += 3) cloud.push_back(points_m[k], points_m[k + 1], points_m[k + 2]);
    const Eigen::Vector3f origin = sensor_at(0.2 * i).cast<float>();
    stock.insertPointCloud(cloud, octomap::point3d(origin.x(), origin.y(), origin.z()));
  }
  const OccupancyMap ours = floor_map();
  std::ostringstream full, binary;
  static_cast<octomap::AbstractOcTree&>(stock).write(full);
  stock.writeBinary(binary);
  EXPECT_EQ(ours.to_bytes(MapFormat::ot), full.str());
  EXPECT_EQ(ours.to_bytes(MapFormat::bt), binary.str());
}

TEST(OccupancyMap, QueriesDuringASurveyDoNotChangeTheBytes) {
  const OccupancyMap undisturbed = floor_map();
  OccupancyMap map(0.5);
  for (int i = 0; i < 40; ++i) {
    map.insert_scan(floor_scan(0.2 * i), sensor_at(0.2 * i), kNoLimit);
    map.to_bytes(i % 2 ? MapFormat::bt : MapFormat::ot);
    map.occupied_voxels_world_m();
    map.statistics();
  }
  EXPECT_EQ(map.to_bytes(MapFormat::ot), undisturbed.to_bytes(MapFormat::ot));
  EXPECT_EQ(map.to_bytes(MapFormat::bt), undisturbed.to_bytes(MapFormat::bt));
}

TEST(OccupancyMap, ListsCountsAndStatesAgree) {
  const OccupancyMap map = floor_map(0.5, 80);
  const std::vector<double> occupied = map.occupied_voxels_world_m();
  const std::vector<double> free = map.free_voxels_world_m();
  const MapStatistics statistics = map.statistics();
  EXPECT_EQ(occupied.size(), 3 * statistics.occupied_voxels);
  EXPECT_EQ(free.size(), 3 * statistics.free_voxels);
  EXPECT_GT(statistics.occupied_voxels + statistics.free_voxels, statistics.nodes);  // a pruned leaf covers many voxels
  EXPECT_EQ(map.state_at(occupied), std::vector<std::int8_t>(occupied.size() / 3, 1));
  EXPECT_EQ(map.state_at(free), std::vector<std::int8_t>(free.size() / 3, 0));
}

TEST(OccupancyMap, WrittenMapReadsBackTheSame) {
  const OccupancyMap map = floor_map(1.0 / 3);  // a resolution that six digits would change
  for (const MapFormat format : {MapFormat::bt, MapFormat::ot}) {
    const std::string bytes = map.to_bytes(format);
    const OccupancyMap back = OccupancyMap::from_bytes(bytes, "x");
    EXPECT_EQ(back.to_bytes(format), bytes);
    EXPECT_EQ(back.resolution_m(), map.resolution_m());
    EXPECT_EQ(back.occupied_voxels_world_m(), map.occupied_voxels_world_m());
    EXPECT_EQ(back.free_voxels_world_m(), map.free_voxels_world_m());
  }
  const std::string empty = OccupancyMap(0.2).to_bytes(MapFormat::bt);
  EXPECT_EQ(OccupancyMap::from_bytes(empty, "x").to_bytes(MapFormat::bt), empty);
}

TEST(OccupancyMap, OriginMovesTheCubeAndNotTheFile) {
  const Vector3d origin(20'000, -30'000, 100);  // outside the +-16 km of a cube about zero
  OccupancyMap here(0.5), there(0.5, origin);
  here.insert_scan(std::vector<float>{8, 2, -3}, Vector3d::Zero(), kNoLimit);
  there.insert_scan(std::vector<float>{20'008, -29'998, 97}, origin, kNoLimit);
  EXPECT_EQ(there.to_bytes(MapFormat::bt), here.to_bytes(MapFormat::bt));
  const std::vector<double> a = here.occupied_voxels_world_m(), b = there.occupied_voxels_world_m();
  for (int axis = 0; axis < 3; ++axis)
    EXPECT_EQ(b[static_cast<std::size_t>(axis)], a[static_cast<std::size_t>(axis)] + origin[axis]);
}

TEST(OccupancyMap, ScansThatCannotBeInsertedAreRefusedWhole) {
  OccupancyMap map(0.1);
  const std::string before = map.to_bytes(MapFormat::bt);
  const float nan = std::nanf(""), inf = std::numeric_limits<float>::infinity();
  EXPECT_THROW(map.insert_scan(std::vector<float>{1, 1, 1, 4000, 0, 0}, Vector3d::Zero(), kNoLimit), InvalidValue);
  EXPECT_THROW(map.insert_scan(std::vector<float>{1, 1, 1, 3e38f, 0, 0}, Vector3d::Zero(), 5), InvalidValue);
  EXPECT_THROW(map.insert_scan(std::vector<float>{1, 1, 1}, {0, 0, nan}, kNoLimit), InvalidValue);
  EXPECT_THROW(map.insert_scan(std::vector<float>{1, 1, 1}, {0, 0, 1e9}, kNoLimit), InvalidValue);
  EXPECT_THROW(map.insert_scan(std::vector<float>{1, 1, 1}, Vector3d::Zero(), nan), InvalidValue);
  EXPECT_THROW(map.insert_scan(std::vector<float>{3270, 3270, 3270}, {-3270, -3270, -3270}, kNoLimit), InvalidValue);
  map.insert_scan(std::vector<float>{nan, 1, 1, inf, 0, 0}, Vector3d::Zero(), kNoLimit);
  EXPECT_EQ(map.to_bytes(MapFormat::bt), before);
  for (const double bad : {0.0, -1.0, 1e-9, 1e9, double{nan}}) EXPECT_THROW(OccupancyMap{bad}, InvalidValue);
  EXPECT_THROW(OccupancyMap(0.1, {nan, 0, 0}), InvalidValue);
}

TEST(OccupancyMap, FilesCutShortAnywhereAreRefused) {
  for (const MapFormat format : {MapFormat::bt, MapFormat::ot}) {
    const std::string whole = floor_map(2.0, 3).to_bytes(format);
    for (std::size_t size = 0; size < whole.size(); ++size) {
      EXPECT_NE(refusal_of(std::string_view(whole).substr(0, size)), "") << size;
    }
    EXPECT_NE(refusal_of(whole + "x").find("1 bytes follow"), std::string::npos);
  }
}

TEST(OccupancyMap, FilesWithAChangedByteAreReadOrRefused) {
  std::mt19937 random(5);
  for (const MapFormat format : {MapFormat::bt, MapFormat::ot}) {
    const std::string whole = floor_map(2.0, 3).to_bytes(format);
    for (int i = 0; i < 3000; ++i) {
      std::string bytes = whole;
      bytes[random() % bytes.size()] = static_cast<char>(random());
      try {
        OccupancyMap::from_bytes(bytes, "x").statistics();
      } catch (const InvalidValue&) {  // a valid map of other voxels is also acceptable
      }
    }
  }
}

TEST(OccupancyMap, RefusedFilesAreToldWhy) {
  const std::string valid = floor_map(2.0, 3).to_bytes(MapFormat::bt);
  const std::string header = valid.substr(0, valid.find("data\n") + 5);
  EXPECT_NE(refusal_of("P5 100 100").find("not an OctoMap file"), std::string::npos);
  EXPECT_NE(refusal_of(replaced(valid, "id OcTree", "id ColorOcTree")).find("'ColorOcTree', not 'OcTree'"),
            std::string::npos);
  EXPECT_NE(refusal_of(replaced(valid, "size ", "size 1")).find("but the header says 1"), std::string::npos);
  EXPECT_NE(refusal_of(replaced(valid, "res 2", "res 0")).find("must be in [0.001, 1000] m"), std::string::npos);
  EXPECT_NE(refusal_of(replaced(valid, "res 2", "res nan")).find("must be in"), std::string::npos);
  EXPECT_NE(refusal_of(replaced(valid, "res 2", "res two")).find("'two', not a number"), std::string::npos);
  EXPECT_NE(refusal_of(header + std::string(1'000'000, '\xff')).find("deeper than 16"), std::string::npos);
  EXPECT_NE(refusal_of(header + std::string(2, '\0')).find("without children"), std::string::npos);
}

TEST(OccupancyMap, HugeLeafIsCountedButNotListed) {
  const std::string header = "# Octomap OcTree binary file\nid OcTree\nsize 2\nres 0.5\ndata\n";
  const OccupancyMap map = OccupancyMap::from_bytes(header + std::string("\x02\0", 2), "x");
  EXPECT_EQ(map.statistics().occupied_voxels, std::uint64_t{1} << 45);
  EXPECT_THROW(map.occupied_voxels_world_m(), InvalidValue);
}

TEST(OccupancyMap, MapWhoseWholeCubeIsKnownWritesTheSameFile) {
  const std::string bytes = octree_header(MapFormat::bt, 9, 0.5) + "UU";  // eight free children
  const OccupancyMap map = OccupancyMap::from_bytes(bytes, "x");
  EXPECT_EQ(map.statistics().free_voxels, std::uint64_t{1} << 48);
  EXPECT_EQ(map.to_bytes(MapFormat::bt), bytes);
}

TEST(OccupancyMap, AProcessThatEndsCanRemoveWhatItIsWriting) {
  const Folder folder;
  {
    AtomicFile file((folder.path / "map.bt").string());
    file.append("half of it");
    EXPECT_EQ(folder.files(), 1u);
    remove_unfinished_files();
    EXPECT_EQ(folder.files(), 0u);
    EXPECT_THROW(file.commit(), FileError);
  }
  write_file_atomically((folder.path / "map.bt").string(), "whole");
  remove_unfinished_files();
  EXPECT_EQ(folder.files(), 1u) << "what is finished stays";
}

TEST(OccupancyMap, OnlyRegularFilesAreRead) {
  const Folder folder;
  for (const std::string& path : {(folder.path / "none.bt").string(), folder.path.string(), std::string("/dev/zero")}) {
    EXPECT_THROW(OccupancyMap::read(path), FileError);
  }
}

TEST(OccupancyMap, FullDiskLeavesTheOldFile) {
  const Folder folder;
  const std::string path = folder.path / "map.bt";
  OccupancyMap(0.5).write(path, MapFormat::bt);
  const OccupancyMap map = floor_map();
  rlimit limit{};
  getrlimit(RLIMIT_FSIZE, &limit);
  const rlimit tight{1000, limit.rlim_max};
  std::signal(SIGXFSZ, SIG_IGN);
  setrlimit(RLIMIT_FSIZE, &tight);
  EXPECT_THROW(map.write(path, MapFormat::bt), FileError);
  setrlimit(RLIMIT_FSIZE, &limit);
  EXPECT_EQ(OccupancyMap::read(path).statistics().nodes, 0u);
  EXPECT_EQ(folder.files(), 1u);
  map.write(path, MapFormat::bt);
  EXPECT_EQ(OccupancyMap::read(path).to_bytes(MapFormat::bt), map.to_bytes(MapFormat::bt));
  EXPECT_EQ(folder.files(), 1u);
}

TEST(OccupancyMap, OnlyRegularFilesAreReplaced) {
  const Folder folder;
  const OccupancyMap map(0.5);
  EXPECT_THROW(map.write("/dev/full", MapFormat::bt), FileError);
  EXPECT_THROW(map.write(folder.path, MapFormat::bt), FileError);
  EXPECT_THROW(map.write(folder.path / "none" / "map.bt", MapFormat::bt), FileError);
  map.write(folder.path / "real.bt", MapFormat::bt);
  fs::create_symlink("real.bt", folder.path / "link.bt");
  map.write(folder.path / "link.bt", MapFormat::bt);
  EXPECT_TRUE(fs::is_symlink(folder.path / "link.bt"));
  EXPECT_TRUE(fs::is_character_file("/dev/full"));
}

}  // namespace
}  // namespace uwsim
