#include "uwsim/sonar/forward_looking.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "imaging_pool.h"
#include "uwsim/core/check.h"
#include "uwsim/sonar/beam_pattern.h"

namespace uwsim {
namespace {

using testing::at;
using testing::beam_of;
using testing::flat_bed;
using testing::kDegree;
using testing::quiet_forward_looking;

const RandomStream kRandom(7, "look");
constexpr double kHeight_m = 5;

std::vector<float> look(const ForwardLookingModel& model, const World& world, const Pose& pose, int threads = 1) {
  return forward_look(model, RayScene(world), world.water, pose, kRandom, 0, threads);
}

World with_box(World world, const Eigen::Vector3d& middle_m, const Eigen::Vector3d& size_m) {
  TriangleMesh box = testing::box(size_m.x(), size_m.y(), size_m.z());
  for (auto& v : box.vertices_m) v += middle_m;
  world.add_solid("box", box);
  return world;
}

TEST(ForwardLooking, ASmallTargetAppearsAtItsRangeAndBearing) {
  ForwardLookingModel model = quiet_forward_looking();
  model.vertical_width_rad = 5 * kDegree;
  for (const auto& [range_m, beam] : {std::pair{8.0, 30}, {21.03, 5}, {33.0, 55}}) {
    const double bearing = model.bearing_rad(beam);
    const Eigen::Vector3d target(range_m * std::cos(bearing), range_m * std::sin(bearing), -30);
    const auto levels = look(model, with_box({}, target, {0.05, 0.05, 0.05}), at({0, 0, -30}));
    const auto brightest = std::max_element(levels.begin(), levels.end()) - levels.begin();
    EXPECT_EQ(brightest % model.beams, beam);
    EXPECT_NEAR(model.acoustics.bin_centre_m(static_cast<int>(brightest / model.beams)), range_m, 0.1);
  }
}

/// Echo level of a level bed by the active sonar equation: spreading, absorption, Lambert, the cell's area.
double bed_level_db(const ForwardLookingModel& model, const Water& water, double z_m, double range_m) {
  const double sine = kHeight_m / range_m;
  const BeamPattern across(model.beam_width_rad, model.taper, 0);
  double width_rad = 0;  // of a beam with square shoulders that hears as much
  for (double angle = -0.15; angle < 0.15; angle += 1e-5) width_rad += 1e-5 * across.power(angle);
  const double area_m2 = range_m * width_rad * model.acoustics.bin_m();  // rho d(rho) = R dR on a level bed
  const double vertical = BeamPattern(model.vertical_width_rad, 0.46, 0).power(std::asin(sine));
  return model.acoustics.source_level_db + model.acoustics.bottom_strength_db + 20 * std::log10(sine) +
         10 * std::log10(area_m2 * vertical) - 40 * std::log10(range_m) -
         2 * model.acoustics.absorption_db_m(water, z_m) * range_m;
}

TEST(ForwardLooking, AFlatBedIsAsLoudAsTheSonarEquationSays) {
  const ForwardLookingModel model = quiet_forward_looking();
  const World world = flat_bed(-20);
  const auto column = beam_of(look(model, world, at({0, 0, -20 + kHeight_m})), model.beams, 30);
  for (int bin = 80; bin < 400; bin += 20) {
    const double range = model.acoustics.bin_centre_m(bin);
    EXPECT_NEAR(column[static_cast<std::size_t>(bin)], bed_level_db(model, world.water, -15, range), 0.05) << range;
  }
}

TEST(ForwardLooking, TimeVariedGainMakesAnEvenBedEven) {
  ForwardLookingModel model = quiet_forward_looking();
  const auto unevenness = [&] {
    const auto column = beam_of(look(model, flat_bed(-20), at({0, 0, -20 + kHeight_m})), model.beams, 30);
    const auto [low, high] = std::minmax_element(column.begin() + 100, column.end());  // from 10 m on
    return *high - *low;
  };
  EXPECT_GT(unevenness(), 30);
  model.acoustics.time_varied_gain = true;
  EXPECT_LT(unevenness(), 1);
}

TEST(ForwardLooking, AbsorptionTakesTwiceItsDecibelsPerMetre) {
  const World world = flat_bed(-20);
  ForwardLookingModel low = quiet_forward_looking(), high = low;
  low.acoustics.frequency_hz = 200e3;
  high.acoustics.frequency_hz = 900e3;
  const auto near = beam_of(look(low, world, at({0, 0, -15})), low.beams, 30);
  const auto far = beam_of(look(high, world, at({0, 0, -15})), low.beams, 30);
  const double more_db_m =
      high.acoustics.absorption_db_m(world.water, -15) - low.acoustics.absorption_db_m(world.water, -15);
  EXPECT_GT(more_db_m, 0.1);
  for (std::size_t bin = 100; bin < 400; bin += 50) {
    const double range = low.acoustics.bin_centre_m(static_cast<int>(bin));
    EXPECT_NEAR(near[bin] - far[bin], 2 * more_db_m * range, 2 * more_db_m * low.acoustics.bin_m()) << range;
  }
}

TEST(ForwardLooking, TheShadowBehindABoxEndsWhereTheRayOverItsTopMeetsTheBed) {
  ForwardLookingModel model = quiet_forward_looking();
  model.beam_width_rad = 0.3 * kDegree;  // else side lobes see the box's far edge a little further away
  model.columns_per_beam = 8;
  const double top = 1.5, front = 12, back = 13;
  const World world = with_box(flat_bed(-20), {(front + back) / 2, 0, -20 + top / 2}, {back - front, 8, top});
  const auto column = beam_of(look(model, world, at({0, 0, -20 + kHeight_m})), model.beams, 30);
  const double begins = std::hypot(back, kHeight_m - top);
  const double ends = std::hypot(back * kHeight_m / (kHeight_m - top), kHeight_m);
  for (int bin = 0; bin < 400; ++bin) {
    const double range = model.acoustics.bin_centre_m(bin);
    const double level = column[static_cast<std::size_t>(bin)];
    if (range > begins + 0.1 && range < ends - 0.1) {
      EXPECT_LT(level, 0) << "in the shadow at " << range;
    } else if ((range > kHeight_m + 0.2 && range < begins - 0.1) || range > ends + 0.1) {
      EXPECT_GT(level, 20) << "in the light at " << range;
    }
  }
}

TEST(ForwardLooking, TheArrayHearsAStrongTargetInItsSideLobesToo) {
  ForwardLookingModel model = quiet_forward_looking();
  const World world = with_box({}, {20, 0, -30}, {0.05, 0.05, 0.05});
  const auto levels = look(model, world, at({0, 0, -30}));
  const auto row = std::max_element(levels.begin(), levels.end()) - levels.begin() - 30;
  const BeamPattern across(model.beam_width_rad, model.taper, 1e-4);
  for (int beam = 27; beam < 34; ++beam) {
    const double off = model.bearing_rad(beam);
    EXPECT_NEAR(levels[static_cast<std::size_t>(row + beam)] - levels[static_cast<std::size_t>(row + 30)],
                10 * std::log10(across.power(off)), 1.0)
        << beam;
  }
}

TEST(ForwardLooking, OnlyNoiseIsHeardAboveTheWaterWithinTheGroundAndFromThere) {
  ForwardLookingModel model = quiet_forward_looking();
  model.rays_per_column = 200;
  const World world = with_box(flat_bed(-20), {10, 0, 3}, {2, 20, 4});  // a dry box ahead
  for (const Pose& pose : {at({0, 0, 1}), at({0, 0, -21})}) {
    for (const float level : look(model, world, pose)) ASSERT_LT(level, -290) << pose.position_m.z();
  }
  const auto beneath = beam_of(look(model, world, at({0, 0, -0.5})), model.beams, 30);
  for (std::size_t bin = 0; bin < 193; ++bin) ASSERT_LT(beneath[bin], -290) << "nearer than the bed, 19.5 m below";
  EXPECT_GT(beneath[200], 50);
  const auto inside = with_box(flat_bed(-20), {0, 0, -10}, {4, 4, 4});
  for (const float level : look(model, inside, at({0, 0, -10}))) ASSERT_LT(level, -290);
}

TEST(ForwardLooking, APictureIsTheSameAgainWhateverTheThreads) {
  ForwardLookingModel model = quiet_forward_looking();
  model.rays_per_column = 100;
  model.acoustics.looks = 1;
  model.acoustics.noise_level_db = 40;
  const World world = flat_bed(-20);
  const auto one = look(model, world, at({0, 0, -15}));
  EXPECT_EQ(one, look(model, world, at({0, 0, -15})));
  EXPECT_EQ(one, look(model, world, at({0, 0, -15}), 3));
  EXPECT_NE(one, forward_look(model, RayScene(world), world.water, at({0, 0, -15}), kRandom, 1));
  EXPECT_NE(one, forward_look(model, RayScene(world), world.water, at({0, 0, -15}), RandomStream(8, "look"), 0));
}

TEST(ForwardLooking, RefusesModelsThatAreNone) {
  const ForwardLookingModel good = quiet_forward_looking();
  EXPECT_NO_THROW(good.check());
  const auto refused = [&](auto change) {
    ForwardLookingModel model = good;
    change(model);
    EXPECT_THROW(model.check(), InvalidValue);
  };
  refused([](auto& m) { m.beams = 0; });
  refused([](auto& m) { m.field_of_view_rad = 361 * kDegree; });
  refused([](auto& m) { m.acoustics.frequency_hz = -1; });
  refused([](auto& m) { m.acoustics.range_max_m = 0; });
  refused([](auto& m) { m.acoustics.range_bins = 0; });
  refused([](auto& m) { m.acoustics.looks = -1; });
  refused([](auto& m) { m.acoustics.noise_level_db = std::nan(""); });
  refused([](auto& m) { m.beam_width_rad = 0; });
  refused([](auto& m) { m.vertical_width_rad = 4; });
  refused([](auto& m) { m.columns_per_beam = 0; });
  refused([](auto& m) { m.rays_per_column = 1; });
}

}  // namespace
}  // namespace uwsim
