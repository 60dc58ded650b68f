#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sonar/imaging_pool.h"
#include "uwsim/core/check.h"
#include "uwsim/sonar/imaging/beam_pattern.h"

namespace uwsim {
namespace {

using testing::at;
using testing::flat_bed;
using testing::ImagingModel;
using testing::kDegree;
using testing::quiet_side_scan;

struct Lines {
  std::vector<float> port_db, starboard_db, altitude_m;
};

Lines ping(const ImagingModel& model, const World& world, const testing::Pings& pings) {
  const auto array = [&](const char* name) { return testing::values_of(model, world, pings, name); };
  return {array("port_db"), array("starboard_db"), array("altitude_m")};
}

TEST(SideScan, TheFirstReturnIsTheAltitude) {
  ImagingModel model = quiet_side_scan();
  model["noise_level_db"] = 50;
  model["looks"] = 1;
  const std::vector poses{at({0, 0, -4.03}), at({0, 0, -11}), at({0, 0, -17.5})};
  const Lines lines = ping(model, flat_bed(-20), {poses});
  for (std::size_t k = 0; k < poses.size(); ++k) {
    EXPECT_NEAR(lines.altitude_m[k], poses[k].position_m.z() + 20, model.acoustics().bin_m()) << k;
  }
  EXPECT_TRUE(std::isinf(ping(model, flat_bed(-200), {{at({0, 0, -10})}}).altitude_m[0])) << "no bottom within range";
}

TEST(SideScan, AFlatBedIsEquallyLoudOnBothSidesAndAsTheSonarEquationSays) {
  const ImagingModel model = quiet_side_scan();
  const World world = flat_bed(-20);
  const Lines lines = ping(model, world, {{at({0, 0, -12})}});
  const BeamPattern along(model["along_width_rad"], 0.46, 0), vertical(model["vertical_width_rad"], 0.46, 1e-3);
  double width_rad = 0;  // the three planes sample the pattern at -2/3, 0 and 2/3 of the width
  for (const double aside : {-2.0 / 3, 0.0, 2.0 / 3}) {
    width_rad += along.power(aside * model["along_width_rad"]) * 2 * model["along_width_rad"] / 3;
  }
  for (std::size_t bin = 100; bin < 500; bin += 20) {
    const double range = model.acoustics().bin_centre_m(static_cast<int>(bin)), sine = 8 / range;
    const double beam = vertical.power(std::asin(sine) - model["depression_rad"]);
    const double cell_m2 = range * width_rad * model.acoustics().bin_m() / std::sqrt(1 - sine * sine);
    const double expected = model["source_level_db"] + model["bottom_strength_db"] + 20 * std::log10(sine) +
                            10 * std::log10(cell_m2 * beam) - 40 * std::log10(range) -
                            2 * model.acoustics().absorption_db_m(world.water, -12) * range;
    EXPECT_NEAR(lines.port_db[bin], expected, 0.15) << range;
    EXPECT_NEAR(lines.port_db[bin], lines.starboard_db[bin], 1e-3);
  }
}

TEST(SideScan, ATargetToPortAppearsToPortAtItsSlantRangeWithAShadowBehindIt) {
  const ImagingModel model = quiet_side_scan();
  World world = flat_bed(-20);
  TriangleMesh wall = testing::box(4, 0.5, 2);
  for (auto& v : wall.vertices_m) v += Eigen::Vector3d(0, 20.25, -19);
  world.add_solid("wall", wall);
  const Lines lines = ping(model, world, {{at({0, 0, -12})}});
  const auto level = [&](double range) { return lines.port_db[static_cast<std::size_t>(range / 0.1)]; };
  // From the foot of the box's face to the point where the ray over its far upper edge hits the bed.
  const double begins = std::hypot(20, 8), ends = std::hypot(20.5 * 8 / 6, 8);
  for (double range = begins + 0.15; range < ends - 0.15; range += 0.1) EXPECT_LT(level(range), 0) << range;
  EXPECT_GT(level(ends + 0.2), 20);
  const auto starboard = std::max_element(lines.starboard_db.begin() + 200, lines.starboard_db.end());
  const auto port = std::max_element(lines.port_db.begin() + 200, lines.port_db.end());
  EXPECT_GT(*port, *starboard + 10) << "its face";
  EXPECT_NEAR(model.acoustics().bin_centre_m(static_cast<int>(port - lines.port_db.begin())), std::hypot(20, 6.8), 1);
}

TEST(SideScan, PingsAreTheSameOneByOneTogetherAndOnManyThreads) {
  ImagingModel model = quiet_side_scan();
  model["looks"] = 1;
  model["noise_level_db"] = 40;
  const World world = flat_bed(-20);
  const std::vector poses{at({0, 0, -12}), at({1, 0, -12}), at({2, 0, -12})};
  const Lines together = ping(model, world, {.poses = poses, .first_ping = 4});
  EXPECT_EQ(together.port_db, ping(model, world, {.poses = poses, .threads = 3, .first_ping = 4}).port_db);
  for (std::size_t k = 0; k < poses.size(); ++k) {
    const Lines alone = ping(model, world, {.poses = {poses[k]}, .first_ping = 4 + k});
    EXPECT_TRUE(std::equal(alone.port_db.begin(), alone.port_db.end(),
                           together.port_db.begin() + static_cast<std::ptrdiff_t>(500 * k)));
    EXPECT_EQ(alone.altitude_m[0], together.altitude_m[k]);
  }
  EXPECT_NE(std::vector(together.port_db.begin(), together.port_db.begin() + 500),
            std::vector(together.port_db.begin() + 500, together.port_db.begin() + 1000));
}

TEST(SideScan, RefusesParametersOutOfRange) {
  const auto refused = [](auto change) {
    ImagingModel model = quiet_side_scan();
    change(model);
    EXPECT_THROW(model.make(), InvalidValue);
  };
  EXPECT_NO_THROW(quiet_side_scan().make());
  refused([](auto& m) { m["along_width_rad"] = 0; });
  refused([](auto& m) { m["vertical_width_rad"] = 10; });
  refused([](auto& m) { m["depression_rad"] = -1 * kDegree; });
  refused([](auto& m) { m["planes"] = 0; });
  refused([](auto& m) { m["detection_db"] = 0; });
  refused([](auto& m) { m["range_bins"] = -4; });
}

}  // namespace
}  // namespace uwsim
