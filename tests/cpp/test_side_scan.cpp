#include "uwsim/sonar/side_scan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "imaging_pool.h"
#include "uwsim/core/check.h"
#include "uwsim/sonar/beam_pattern.h"

namespace uwsim {
namespace {

using testing::at;
using testing::flat_bed;
using testing::kDegree;
using testing::quiet_side_scan;

const RandomStream kRandom(7, "side");

SideScanLines ping(const SideScanModel& model, const World& world, std::span<const Pose> poses, int threads = 1) {
  return side_scan(model, RayScene(world), world.water, poses, kRandom, 0, threads);
}

TEST(SideScan, TheFirstReturnIsTheAltitude) {
  SideScanModel model = quiet_side_scan();
  model.acoustics.noise_level_db = 50;
  model.acoustics.looks = 1;
  const std::array poses{at({0, 0, -4.03}), at({0, 0, -11}), at({0, 0, -17.5})};
  const auto lines = ping(model, flat_bed(-20), poses);
  for (std::size_t k = 0; k < poses.size(); ++k) {
    EXPECT_NEAR(lines.altitude_m[k], poses[k].position_m.z() + 20, model.acoustics.bin_m()) << k;
  }
  const std::array high{at({0, 0, -10})};
  EXPECT_TRUE(std::isinf(ping(model, flat_bed(-200), high).altitude_m[0])) << "nothing within reach";
}

TEST(SideScan, AFlatBedIsAlikeToBothSidesAndAsLoudAsTheSonarEquationSays) {
  const SideScanModel model = quiet_side_scan();
  const World world = flat_bed(-20);
  const std::array poses{at({0, 0, -12})};
  const auto lines = ping(model, world, poses);
  const BeamPattern along(model.along_width_rad, 0.46, 0), vertical(model.vertical_width_rad, 0.46, 1e-3);
  double width_rad = 0;  // the three planes sum the pattern at a third of the way, at 0 and at two thirds
  for (const double aside : {-2.0 / 3, 0.0, 2.0 / 3}) {
    width_rad += along.power(aside * model.along_width_rad) * 2 * model.along_width_rad / 3;
  }
  for (std::size_t bin = 100; bin < 500; bin += 20) {
    const double range = model.acoustics.bin_centre_m(static_cast<int>(bin)), sine = 8 / range;
    const double beam = vertical.power(std::asin(sine) - model.depression_rad);
    const double cell_m2 = range * width_rad * model.acoustics.bin_m() / std::sqrt(1 - sine * sine);
    const double expected = model.acoustics.source_level_db + model.acoustics.bottom_strength_db +
                            20 * std::log10(sine) + 10 * std::log10(cell_m2 * beam) - 40 * std::log10(range) -
                            2 * model.acoustics.absorption_db_m(world.water, -12) * range;
    EXPECT_NEAR(lines.port_db[bin], expected, 0.15) << range;
    EXPECT_NEAR(lines.port_db[bin], lines.starboard_db[bin], 1e-3);
  }
}

TEST(SideScan, ATargetToPortIsHeardToPortAtItsSlantRangeAndShadowsWhatIsBehind) {
  const SideScanModel model = quiet_side_scan();
  World world = flat_bed(-20);
  TriangleMesh wall = testing::box(4, 0.5, 2);
  for (auto& v : wall.vertices_m) v += Eigen::Vector3d(0, 20.25, -19);
  world.add_solid("wall", wall);
  const std::array poses{at({0, 0, -12})};
  const auto lines = ping(model, world, poses);
  const auto level = [&](double range) { return lines.port_db[static_cast<std::size_t>(range / 0.1)]; };
  // From the foot of its face to where the ray over its far upper edge meets the bed.
  const double begins = std::hypot(20, 8), ends = std::hypot(20.5 * 8 / 6, 8);
  for (double range = begins + 0.15; range < ends - 0.15; range += 0.1) EXPECT_LT(level(range), 0) << range;
  EXPECT_GT(level(ends + 0.2), 20);
  const auto starboard = std::max_element(lines.starboard_db.begin() + 200, lines.starboard_db.end());
  const auto port = std::max_element(lines.port_db.begin() + 200, lines.port_db.end());
  EXPECT_GT(*port, *starboard + 10) << "its face";
  EXPECT_NEAR(model.acoustics.bin_centre_m(static_cast<int>(port - lines.port_db.begin())), std::hypot(20, 6.8), 1);
}

TEST(SideScan, PingsMayBeHeardOneByOneAndOnManyThreads) {
  SideScanModel model = quiet_side_scan();
  model.acoustics.looks = 1;
  model.acoustics.noise_level_db = 40;
  const World world = flat_bed(-20);
  const RayScene scene(world);
  const std::array poses{at({0, 0, -12}), at({1, 0, -12}), at({2, 0, -12})};
  const auto together = side_scan(model, scene, world.water, poses, kRandom, 4);
  EXPECT_EQ(together.port_db, side_scan(model, scene, world.water, poses, kRandom, 4, 3).port_db);
  for (std::size_t k = 0; k < poses.size(); ++k) {
    const auto alone = side_scan(model, scene, world.water, {&poses[k], 1}, kRandom, 4 + k);
    EXPECT_TRUE(std::equal(alone.port_db.begin(), alone.port_db.end(),
                           together.port_db.begin() + static_cast<std::ptrdiff_t>(500 * k)));
    EXPECT_EQ(alone.altitude_m[0], together.altitude_m[k]);
  }
  EXPECT_NE(std::vector(together.port_db.begin(), together.port_db.begin() + 500),
            std::vector(together.port_db.begin() + 500, together.port_db.begin() + 1000));
}

TEST(SideScan, RefusesModelsThatAreNone) {
  const auto refused = [](auto change) {
    SideScanModel model = quiet_side_scan();
    change(model);
    EXPECT_THROW(model.check(), InvalidValue);
  };
  EXPECT_NO_THROW(quiet_side_scan().check());
  refused([](auto& m) { m.along_width_rad = 0; });
  refused([](auto& m) { m.vertical_width_rad = 10; });
  refused([](auto& m) { m.depression_rad = -1 * kDegree; });
  refused([](auto& m) { m.planes = 0; });
  refused([](auto& m) { m.detection_db = 0; });
  refused([](auto& m) { m.acoustics.range_bins = -4; });
}

}  // namespace
}  // namespace uwsim
