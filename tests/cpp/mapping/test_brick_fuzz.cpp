// Small random scans with all kinds of edge cases: the brick engine must produce the same bytes as OctoMap's own
// insertPointCloud.
#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include <cmath>
#include <limits>
#include <random>
#include <sstream>

#include "mapping/map_cases.h"
#include "sanitized.h"
#include "uwsim/core/instruction_set.h"
#include "uwsim/mapping/occupancy_map.h"
#include "uwsim/mapping/quiet_stderr.h"

extern template class octomap::OcTreeBaseImpl<octomap::OcTreeNode, octomap::AbstractOccupancyOcTree>;
extern template class octomap::OccupancyOcTreeBase<octomap::OcTreeNode>;

namespace uwsim {
namespace {

struct Ping {
  std::vector<float> points_m;
  Eigen::Vector3d origin_m;
};

struct Case {
  double resolution_m;
  OccupancyModel model;
  double max_range_m;
  std::vector<Ping> pings;
};

class CaseMaker {
 public:
  explicit CaseMaker(unsigned seed) : random_(seed) {}

  Case make() {
    Case made{pick({0.05, 0.1, 0.2, 0.25, 0.3, 0.5, 1.0, 2.0}), {}, kNoLimit, {}};
    if (chance(0.5)) made.model = model();
    if (chance(0.5)) made.max_range_m = pick({1e-9, 0.1, 1.0, 3.0, 5.0, 20.0});
    const double spread_m = made.resolution_m * pick({0.6, 3.0, 12.0, 40.0});
    const Eigen::Vector3d middle_m = chance(0.3) ? Eigen::Vector3d(1234.5, -2048, 77.7) * made.resolution_m
                                                 : Eigen::Vector3d(Eigen::Vector3d::Zero());
    const int pings = 1 + static_cast<int>(random_() % 5);
    for (int i = 0; i < pings; ++i) {
      Ping ping;
      ping.origin_m = middle_m + awkward(spread_m * 0.3, made.resolution_m);
      const int points = static_cast<int>(random_() % 40);
      for (int k = 0; k < points; ++k) {
        const Eigen::Vector3d offset_m = awkward(spread_m, made.resolution_m);
        const Eigen::Vector3f point_m = (chance(0.05) ? ping.origin_m : middle_m + offset_m).cast<float>();
        for (int axis = 0; axis < 3; ++axis) ping.points_m.push_back(chance(0.01) ? not_finite() : point_m[axis]);
      }
      made.pings.push_back(ping);
      while (chance(0.3)) made.pings.push_back(ping);  // repeated, so that voxels reach the clamping limits
    }
    return made;
  }

  /// Long, nearly level fans and single rays like those of a sonar. Many cross two faces at the same point.
  Case make_level() {
    Case made{pick({0.1, 0.2, 0.25, 0.5}), {}, kNoLimit, {}};
    if (chance(0.5)) made.max_range_m = made.resolution_m * pick({30.0, 77.7, 150.0});
    const int pings = 1 + static_cast<int>(random_() % 3);
    for (int i = 0; i < pings; ++i) {
      Ping ping;
      ping.origin_m = awkward(30 * made.resolution_m, made.resolution_m);
      const double tilt = pick({0.0, 0.01, 0.05, 0.12, 0.2, 0.24, 0.26}) * (chance(0.5) ? 1 : -1);
      const double sheer = chance(0.5) ? 0 : uniform(-0.2, 0.2), middle = uniform(-4, 4), width = uniform(0.001, 3);
      const int beams = 1 + static_cast<int>(random_() % 120);
      for (int k = 0; k < beams; ++k) {
        const double angle = middle + width * k / beams, steps = uniform(5, 160);
        Eigen::Vector3d direction(std::cos(angle), std::sin(angle), tilt + sheer * std::sin(angle));
        if (chance(0.2)) direction = (direction * pick({4.0, 8.0, 16.0})).array().round();  // ties
        const Eigen::Vector3d point_m = ping.origin_m + direction * (chance(0.2) ? std::round(steps) : steps) *
                                                            made.resolution_m / std::max(1.0, direction.norm() / 3);
        for (int axis = 0; axis < 3; ++axis) ping.points_m.push_back(static_cast<float>(point_m[axis]));
      }
      made.pings.push_back(ping);
    }
    return made;
  }

  unsigned number() { return static_cast<unsigned>(random_()); }

 private:
  bool chance(double probability) { return uniform(0, 1) < probability; }
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  double pick(std::initializer_list<double> choice) { return choice.begin()[random_() % choice.size()]; }
  float not_finite() {
    const float inf = std::numeric_limits<float>::infinity();
    return static_cast<float>(pick({std::nan(""), inf, -inf}));
  }

  OccupancyModel model() {
    OccupancyModel odd{pick({0.5, 0.55, 0.7, 0.9, 0.99}), pick({0.5, 0.45, 0.4, 0.2, 0.01}), 0, 0};
    odd.clamping_min = pick({0.0001, 0.1192, 0.3, 0.45, 0.5, 0.6});
    odd.clamping_max = odd.clamping_min + pick({0.01, 0.05, 0.2}) + (chance(0.5) ? 0.15 : 0);
    return odd;
  }

  /// A random offset: to a voxel's corner, to its centre, along an axis, along a diagonal, or arbitrary.
  Eigen::Vector3d awkward(double spread_m, double resolution_m) {
    Eigen::Vector3d offset_m;
    for (double& x : offset_m) x = uniform(-spread_m, spread_m);
    const double kind = uniform(0, 1);
    if (kind < 0.25) return (offset_m / resolution_m).array().round() * resolution_m;
    if (kind < 0.4) return ((offset_m / resolution_m).array().floor() + 0.5) * resolution_m;
    if (kind < 0.5) return Eigen::Vector3d::Constant(offset_m.x());
    if (kind < 0.6) return Eigen::Vector3d(0, 0, offset_m.z());
    if (kind < 0.7) return Eigen::Vector3d(offset_m.x(), -offset_m.x(), 0);
    return offset_m;
  }

  std::mt19937 random_;
};

struct Bytes {
  std::string ot, bt;
  bool operator==(const Bytes&) const = default;
};

std::string describe(const Case& one, const Bytes& got, const Bytes& expected) {
  std::ostringstream text;
  text << "resolution " << one.resolution_m << ", hit " << one.model.hit << ", miss " << one.model.miss << ", clamping "
       << one.model.clamping_min << " to " << one.model.clamping_max << ", range " << one.max_range_m << ", "
       << one.pings.size() << " pings, .ot " << got.ot.size() << " for " << expected.ot.size() << " bytes, .bt "
       << got.bt.size() << " for " << expected.bt.size() << " bytes";
  if (got.ot != expected.ot) text << ", .ot differs";
  if (got.bt != expected.bt) text << ", .bt differs";
  return text.str();
}

/// The bytes that OctoMap itself produces, called as by any other program.
Bytes octomaps(const Case& one) {
  octomap::OcTree tree(one.resolution_m);
  tree.setProbHit(one.model.hit);
  tree.setProbMiss(one.model.miss);
  tree.setClampingThresMin(one.model.clamping_min);
  tree.setClampingThresMax(one.model.clamping_max);
  for (const Ping& ping : one.pings) {
    octomap::Pointcloud cloud;
    for (std::size_t i = 0; i < ping.points_m.size(); i += 3) {
      const float* p = &ping.points_m[i];
      if (std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2])) cloud.push_back(p[0], p[1], p[2]);
    }
    const Eigen::Vector3f origin = ping.origin_m.cast<float>();
    tree.insertPointCloud(cloud, octomap::point3d(origin.x(), origin.y(), origin.z()),
                          std::isinf(one.max_range_m) ? -1.0 : one.max_range_m);
  }
  std::ostringstream full, binary;
  static_cast<octomap::AbstractOcTree&>(tree).write(full);
  const QuietStderr quiet;
  tree.writeBinary(binary);
  return {full.str(), binary.str()};
}

Bytes bytes_of(const OccupancyMap& map) { return {map.to_bytes(MapFormat::ot), map.to_bytes(MapFormat::bt)}; }

OccupancyMap empty_map(const Case& one, const MapOptions& how) {
  MapOptions options = how;
  options.model = one.model;
  return OccupancyMap(one.resolution_m, Eigen::Vector3d::Zero(), options);
}

Bytes one_by_one(const Case& one, const MapOptions& how) {
  OccupancyMap map = empty_map(one, how);
  for (const Ping& ping : one.pings) map.insert_scan(ping.points_m, ping.origin_m, one.max_range_m);
  return bytes_of(map);
}

/// Inserts scans in batches of random sizes, some of them empty.
Bytes batched(const Case& one, const MapOptions& how, int threads, unsigned seed) {
  std::mt19937 random(seed);
  OccupancyMap map = empty_map(one, how);
  for (std::size_t first = 0; first < one.pings.size();) {
    const std::size_t count = std::min<std::size_t>(random() % 4, one.pings.size() - first);
    std::vector<float> points_m;
    std::vector<std::int64_t> counts;
    std::vector<double> origins_m;
    for (std::size_t i = first; i < first + count; ++i) {
      const Ping& ping = one.pings[i];
      points_m.insert(points_m.end(), ping.points_m.begin(), ping.points_m.end());
      counts.push_back(static_cast<std::int64_t>(ping.points_m.size() / 3));
      origins_m.insert(origins_m.end(), ping.origin_m.begin(), ping.origin_m.end());
    }
    map.insert_scans(points_m, counts, origins_m, one.max_range_m, threads);
    first += count;
  }
  return bytes_of(map);
}

class BrickFuzz : public testing::TestWithParam<InstructionSet> {};

TEST_P(BrickFuzz, BytesAreOctomapsForAwkwardScans) {
  if (!processor_has(GetParam())) GTEST_SKIP() << "this processor does not have the instruction set";
  MapOptions bricks;
  bricks.instruction_set = GetParam();
  CaseMaker maker(1234u + static_cast<unsigned>(GetParam()));
  int voxels = 0;
  for (int i = 0; i < cases(700); ++i) {
    const Case one = maker.make();
    const Bytes expected = octomaps(one);
    const Bytes single = one_by_one(one, bricks), together = batched(one, bricks, 1 + i % 2, maker.number());
    ASSERT_TRUE(single == expected) << "case " << i << ": " << describe(one, single, expected);
    ASSERT_TRUE(together == expected) << "case " << i << ", batched: " << describe(one, together, expected);
    voxels += expected.ot.size() > 200;
  }
  EXPECT_GT(voxels, cases(460)) << "too many cases are empty";
}

TEST_P(BrickFuzz, BytesAreOctomapsForSonarFans) {
  if (!processor_has(GetParam())) GTEST_SKIP() << "this processor does not have the instruction set";
  MapOptions bricks;
  bricks.instruction_set = GetParam();
  CaseMaker maker(99u + static_cast<unsigned>(GetParam()));
  for (int i = 0; i < cases(300); ++i) {
    const Case one = maker.make_level();
    const Bytes expected = octomaps(one), got = batched(one, bricks, 1 + i % 2, maker.number());
    ASSERT_TRUE(got == expected) << "case " << i << ": " << describe(one, got, expected);
  }
}

/// A changed model may leave voxels outside the clamping limits, and both limits on one side of "occupied".
TEST(BrickFuzzOfModels, BytesAreOctomapsAfterAChangeOfTheModel) {
  MapOptions octomap;
  octomap.engine = MapEngineKind::octomap;
  CaseMaker maker(4321);
  for (int i = 0; i < cases(200); ++i) {
    const Case one = maker.make(), other = maker.make();
    OccupancyMap expected = empty_map(one, octomap), map = empty_map(one, {});
    for (OccupancyMap* each : {&expected, &map}) {
      for (const Ping& ping : one.pings) each->insert_scan(ping.points_m, ping.origin_m, one.max_range_m);
      each->set_model(other.model);
    }
    ASSERT_TRUE(bytes_of(map) == bytes_of(expected)) << "case " << i;
    for (OccupancyMap* each : {&expected, &map}) {
      for (const Ping& ping : one.pings) each->insert_scan(ping.points_m, ping.origin_m, one.max_range_m);
    }
    ASSERT_TRUE(bytes_of(map) == bytes_of(expected)) << "case " << i << ", scans after the change";
  }
}

INSTANTIATE_TEST_SUITE_P(All, BrickFuzz,
                         testing::Values(InstructionSet::portable, InstructionSet::avx2, InstructionSet::avx512),
                         [](const auto& info) {
                           return std::string(info.param == InstructionSet::portable ? "portable"
                                              : info.param == InstructionSet::avx2   ? "avx2"
                                                                                     : "avx512");
                         });

TEST(OctomapEngine, BytesAreOctomapsForAwkwardScans) {
  MapOptions octomap;
  octomap.engine = MapEngineKind::octomap;
  CaseMaker maker(77);
  for (int i = 0; i < cases(300); ++i) {
    const Case one = maker.make();
    const Bytes expected = octomaps(one);
    ASSERT_TRUE(one_by_one(one, octomap) == expected) << "case " << i;
    ASSERT_TRUE(batched(one, octomap, 2, maker.number()) == expected) << "case " << i;
  }
}

}  // namespace
}  // namespace uwsim
