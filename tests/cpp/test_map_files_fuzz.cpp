// Files that are cut, damaged or made up: a clear error or a sound map, in both engines, and never anything else.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include "map_cases.h"
#include "uwsim/core/check.h"

namespace uwsim {
namespace {

using Eigen::Vector3d;

constexpr MapEngineKind kEngines[] = {MapEngineKind::octomap, MapEngineKind::bricks};

std::string some_file(MapFormat format, unsigned seed) {
  OccupancyMap map(0.5);
  insert_some(map, seed, 3, 4);
  return map.to_bytes(format);
}

/// Reads it with both engines: true if it is taken. What is taken must be whole: it answers, and it survives the way
/// to a file and back.
bool is_taken(const std::string& bytes) {
  bool taken[2];
  std::string written[2];
  for (const MapEngineKind engine : kEngines) {
    const auto i = static_cast<std::size_t>(engine);
    try {
      OccupancyMap map = OccupancyMap::from_bytes(bytes, "fuzz", Vector3d::Zero(), with_engine(engine));
      taken[i] = true;
      written[i] = map.to_bytes(MapFormat::ot);
      const std::vector<double> points_m{0, 0, 0, 0.5, -0.5, 0.3}, directions{1, 1, 1, 0, 0, 1};
      EXPECT_EQ(map.cast_rays(points_m, directions, true, 2).ends.size(), map.state_at(points_m).size());
    } catch (const InvalidValue& error) {
      taken[i] = false;
      EXPECT_NE(std::string(error.what()).find("fuzz"), std::string::npos) << error.what();
    }
  }
  EXPECT_EQ(taken[0], taken[1]);
  EXPECT_TRUE(written[0] == written[1]);
  if (taken[1]) {
    const OccupancyMap back = OccupancyMap::from_bytes(written[1], "back");
    EXPECT_TRUE(back.to_bytes(MapFormat::ot) == written[1]);
  }
  return taken[1];
}

class MapFiles : public testing::TestWithParam<MapFormat> {};

TEST_P(MapFiles, CutAnywhereAreRefused) {
  const std::string file = some_file(GetParam(), 1);
  ASSERT_TRUE(is_taken(file));
  for (std::size_t size = 0; size < file.size(); size += size < 400 ? 1 : 17) {
    ASSERT_FALSE(is_taken(file.substr(0, size))) << size << " bytes";
  }
  EXPECT_FALSE(is_taken(file + '\0'));
}

TEST_P(MapFiles, FlippedBitsAreRefusedOrHarmless) {
  std::mt19937 random(2);
  int taken = 0, refused = 0;
  for (unsigned seed = 0; seed < 3; ++seed) {
    const std::string file = some_file(GetParam(), seed);
    for (int i = 0; i < 1500; ++i) {
      std::string damaged = file;
      // Half of them in the header, where a bit does most.
      const std::size_t reach = i % 2 ? file.size() : 160;
      for (int flips = 1 + i % 3; flips > 0; --flips) damaged[random() % reach] ^= static_cast<char>(1 << random() % 8);
      ++(is_taken(damaged) ? taken : refused);
    }
  }
  EXPECT_GT(taken, 100);  // a log-odds, a comment, free for occupied
  EXPECT_GT(refused, 100);
}

TEST_P(MapFiles, TornApartAreRefusedOrHarmless) {
  std::mt19937 random(3);
  const std::string file = some_file(GetParam(), 4), other = some_file(GetParam(), 5);
  int refused = 0;
  for (int i = 0; i < 600; ++i) {
    std::string damaged = file;
    const std::size_t at = random() % damaged.size(), size = random() % 200;
    switch (i % 4) {
      case 0:
        damaged.erase(at, size);
        break;
      case 1:
        damaged.insert(at, other.substr(random() % other.size(), size));
        break;
      case 2:
        damaged.replace(at, size, std::string(size, static_cast<char>(random())));
        break;
      default:
        damaged = file.substr(0, at) + other.substr(std::min(at, other.size()));
    }
    refused += !is_taken(damaged);
  }
  EXPECT_GT(refused, 400);
}

INSTANTIATE_TEST_SUITE_P(All, MapFiles, testing::Values(MapFormat::bt, MapFormat::ot),
                         [](const auto& info) { return std::string(info.param == MapFormat::bt ? "bt" : "ot"); });

TEST(MapFiles, MadeUpHeadersAreRefused) {
  const std::string file = some_file(MapFormat::bt, 1);
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string changed = file;
    const std::size_t at = changed.find(from);
    EXPECT_NE(at, std::string::npos);
    return changed.replace(at, changed.find('\n', at) - at, to);
  };
  EXPECT_TRUE(is_taken(with("# (feel", "# another comment")));
  for (const char* id : {"id ColorOcTree", "id octree", "id", "id OcTree2"})
    EXPECT_FALSE(is_taken(with("id ", id))) << id;
  for (const char* size :
       {"size 0", "size 1", "size -5", "size 18446744073709551615", "size 99999999999999999999", "size 1e3"}) {
    EXPECT_FALSE(is_taken(with("size ", size))) << size;
  }
  for (const char* res : {"res 0", "res -1", "res nan", "res inf", "res 1e-300", "res 1e300", "res 0.5m", "res"}) {
    EXPECT_FALSE(is_taken(with("res ", res))) << res;
  }
  EXPECT_FALSE(is_taken(with("# Octomap", "# Octomap OcTree file")));  // another format than the body's
  EXPECT_FALSE(is_taken(with("data", "DATA")));
}

/// A small file that says much: 8^depths inner nodes of 2^levels voxels, each with one leaf below.
std::string sparse_file(int levels, int depths) {
  std::string body;
  std::uint64_t nodes = 1;
  const auto node = [&](const auto& self, int at) -> void {
    if (at == levels) {
      body += std::string("\x01\0", 2);
      ++nodes;
      return;
    }
    body += "\xff\xff";
    nodes += 8;
    for (int child = 0; child < 8; ++child) self(self, at - 1);
  };
  std::string deep;
  for (int at = 16; at > levels + depths; --at) {
    deep += std::string("\x03\0", 2);
    ++nodes;
  }
  node(node, levels + depths);
  return octree_header(MapFormat::bt, nodes, 0.5) + deep + body;
}

TEST(MapFiles, MuchMemoryIsRefusedBeforeItIsTaken) {
  // 2^18 chunks of the bricks, half a gigabyte, of a file of less than one megabyte.
  const std::string file = sparse_file(6, 6);
  EXPECT_LT(file.size(), 1'000'000u);
  const auto limited = [](std::size_t bytes) {
    MapOptions options;
    options.memory_limit_bytes = bytes;
    return options;
  };
  const OccupancyMap map = OccupancyMap::from_bytes(file, "much", Vector3d::Zero(), limited(20'000'000));
  EXPECT_GT(map.statistics().evictions, 100'000u);
  // 2^24 of them, 37 GB and more than this machine may give.
  const double there_bytes =
      static_cast<double>(::sysconf(_SC_PHYS_PAGES)) * static_cast<double>(::sysconf(_SC_PAGESIZE));
  if (there_bytes < 70e9) {
    EXPECT_THROW(OccupancyMap::from_bytes(sparse_file(6, 8), "much"), InvalidValue);
  }
  rusage usage;
  ::getrusage(RUSAGE_SELF, &usage);
  EXPECT_LT(usage.ru_maxrss, 600'000);  // kB
}

}  // namespace
}  // namespace uwsim
