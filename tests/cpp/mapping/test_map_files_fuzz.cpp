// Files that are truncated, damaged or forged cause a clear error or are read as a valid map, with the same result in
// both engines.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include "mapping/map_cases.h"
#include "uwsim/core/check.h"

namespace uwsim {
namespace {

using Eigen::Vector3d;

std::string some_file(MapFormat format, unsigned seed) {
  OccupancyMap map(0.5);
  insert_some(map, seed, 3, 4);
  return map.to_bytes(format);
}

/// Reads a file with both engines; returns whether they accept it. An accepted map must answer queries, and be the same
/// after it is written and read again.
bool is_accepted(const std::string& bytes) {
  bool accepted[2];
  std::string written[2];
  for (const MapEngineKind engine : kEngines) {
    const auto i = static_cast<std::size_t>(engine);
    try {
      OccupancyMap map = OccupancyMap::from_bytes(bytes, "fuzz", Vector3d::Zero(), with_engine(engine));
      accepted[i] = true;
      written[i] = map.to_bytes(MapFormat::ot);
      const std::vector<double> points_m{0, 0, 0, 0.5, -0.5, 0.3}, directions{1, 1, 1, 0, 0, 1};
      EXPECT_EQ(map.cast_rays(points_m, directions, true, 2).ends.size(), map.state_at(points_m).size());
    } catch (const InvalidValue& error) {
      accepted[i] = false;
      EXPECT_NE(std::string(error.what()).find("fuzz"), std::string::npos) << error.what();
    }
  }
  EXPECT_EQ(accepted[0], accepted[1]);
  EXPECT_TRUE(written[0] == written[1]);
  if (accepted[1]) {
    const OccupancyMap back = OccupancyMap::from_bytes(written[1], "back");
    EXPECT_TRUE(back.to_bytes(MapFormat::ot) == written[1]);
  }
  return accepted[1];
}

class MapFiles : public testing::TestWithParam<MapFormat> {};

TEST_P(MapFiles, CutShortAnywhereAreRefused) {
  const std::string file = some_file(GetParam(), 1);
  ASSERT_TRUE(is_accepted(file));
  for (std::size_t size = 0; size < file.size(); size += size < 400 ? 1 : 17) {
    ASSERT_FALSE(is_accepted(file.substr(0, size))) << size << " bytes";
  }
  EXPECT_FALSE(is_accepted(file + '\0'));
}

TEST_P(MapFiles, FlippedBitsAreRefusedOrHarmless) {
  std::mt19937 random(2);
  int accepted = 0, refused = 0;
  for (unsigned seed = 0; seed < 3; ++seed) {
    const std::string file = some_file(GetParam(), seed);
    for (int i = 0; i < 1500; ++i) {
      std::string damaged = file;
      // Half of the changes are in the header, where each bit has the largest effect.
      const std::size_t reach = i % 2 ? file.size() : 160;
      for (int flips = 1 + i % 3; flips > 0; --flips) damaged[random() % reach] ^= static_cast<char>(1 << random() % 8);
      ++(is_accepted(damaged) ? accepted : refused);
    }
  }
  EXPECT_GT(accepted, 100);  // a changed log-odds or comment, or free instead of occupied
  EXPECT_GT(refused, 100);
}

TEST_P(MapFiles, WithPiecesMissingOrReplacedAreRefusedOrHarmless) {
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
    refused += !is_accepted(damaged);
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
  EXPECT_TRUE(is_accepted(with("# (feel", "# another comment")));
  for (const char* id : {"id ColorOcTree", "id octree", "id", "id OcTree2"})
    EXPECT_FALSE(is_accepted(with("id ", id))) << id;
  for (const char* size :
       {"size 0", "size 1", "size -5", "size 18446744073709551615", "size 99999999999999999999", "size 1e3"}) {
    EXPECT_FALSE(is_accepted(with("size ", size))) << size;
  }
  for (const char* res : {"res 0", "res -1", "res nan", "res inf", "res 1e-300", "res 1e300", "res 0.5m", "res"}) {
    EXPECT_FALSE(is_accepted(with("res ", res))) << res;
  }
  EXPECT_FALSE(is_accepted(with("# Octomap", "# Octomap OcTree file")));  // does not match the format of the body
  EXPECT_FALSE(is_accepted(with("data", "DATA")));
}

/// A small file of a large map: 8^depths inner nodes with an edge of 2^levels voxels, each with one leaf below it.
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

TEST(MapFiles, MapsThatNeedTooMuchMemoryAreRefusedBeforeTheyTakeIt) {
  // 2^15 chunks, 70 MB, from a file of less than 100 kB.
  const std::string file = sparse_file(6, 5);
  EXPECT_LT(file.size(), 100'000u);
  EXPECT_GT(OccupancyMap::from_bytes(file, "much").statistics().memory_bytes, 60'000'000u);
  // 2^24 chunks, 37 GB: more than half of this machine's memory.
  const double machine_bytes =
      static_cast<double>(::sysconf(_SC_PHYS_PAGES)) * static_cast<double>(::sysconf(_SC_PAGESIZE));
  if (machine_bytes < 70e9) {
    EXPECT_THROW(OccupancyMap::from_bytes(sparse_file(6, 8), "much"), InvalidValue);
  }
  rusage usage;
  ::getrusage(RUSAGE_SELF, &usage);
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  constexpr long kMost_kB = 2'000'000;  // including the sanitizer's own memory
#else
  constexpr long kMost_kB = 600'000;
#endif
  EXPECT_LT(usage.ru_maxrss, kMost_kB);
}

}  // namespace
}  // namespace uwsim
