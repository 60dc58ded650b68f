#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sonar/imaging_pool.h"
#include "uwsim/core/check.h"
#include "uwsim/sonar/beam_angles.h"
#include "uwsim/sonar/imaging/beam_pattern.h"
#include "uwsim/sonar/imaging/surface_echo.h"

namespace uwsim {
namespace {

using testing::at;
using testing::flat_bed;
using testing::ImagingModel;
using testing::kDegree;
using testing::quiet_forward_looking;

constexpr int kBeams = 61, kMiddle = 30;
constexpr double kHeight_m = 5;

/// Returns level_db[bin * kBeams + beam].
std::vector<float> look(const ImagingModel& model, const World& world, const Pose& pose) {
  return testing::values_of(model, world, {.poses = {pose}}, "level_db");
}

std::vector<double> middle_beam(const std::vector<float>& levels) {
  std::vector<double> column;
  for (std::size_t k = kMiddle; k < levels.size(); k += kBeams) column.push_back(levels[k]);
  return column;
}

double bearing_rad(int beam) { return even_beam_angles(60 * kDegree, kBeams).at(beam); }

World with_box(World world, const Eigen::Vector3d& middle_m, const Eigen::Vector3d& size_m) {
  TriangleMesh box = testing::box(size_m.x(), size_m.y(), size_m.z());
  for (auto& v : box.vertices_m) v += middle_m;
  world.add_solid("box", box);
  return world;
}

TEST(ForwardLooking, ASmallTargetAppearsAtItsRangeAndBearing) {
  ImagingModel model = quiet_forward_looking();
  model["vertical_width_rad"] = 5 * kDegree;
  for (const auto& [range_m, beam] : {std::pair{8.0, 30}, {21.03, 5}, {33.0, 55}}) {
    const double bearing = bearing_rad(beam);
    const Eigen::Vector3d target(range_m * std::cos(bearing), range_m * std::sin(bearing), -30);
    const auto levels = look(model, with_box({}, target, {0.05, 0.05, 0.05}), at({0, 0, -30}));
    const auto brightest = std::max_element(levels.begin(), levels.end()) - levels.begin();
    EXPECT_EQ(brightest % kBeams, beam);
    EXPECT_NEAR(model.acoustics().bin_centre_m(static_cast<int>(brightest / kBeams)), range_m, 0.1);
  }
}

/// The echo level of a level bed by the active sonar equation: spreading, absorption, Lambert's law, and the cell's
/// area.
double bed_level_db(const ImagingModel& model, const Water& water, double z_m, double range_m) {
  const double sine = kHeight_m / range_m;
  const BeamPattern across(model["beam_width_rad"], model["taper"], 0);
  double width_rad = 0;  // of an ideal rectangular beam that receives the same power
  for (double angle = -0.15; angle < 0.15; angle += 1e-5) width_rad += 1e-5 * across.power(angle);
  const double area_m2 = range_m * width_rad * model.acoustics().bin_m();  // rho d(rho) = R dR on a level bed
  const double vertical = BeamPattern(model["vertical_width_rad"], 0.46, 0).power(std::asin(sine));
  return model["source_level_db"] + model["bottom_strength_db"] + 20 * std::log10(sine) +
         10 * std::log10(area_m2 * vertical) - 40 * std::log10(range_m) -
         2 * model.acoustics().absorption_db_m(water, z_m) * range_m;
}

TEST(ForwardLooking, AFlatBedIsAsLoudAsTheSonarEquationSays) {
  const ImagingModel model = quiet_forward_looking();
  const World world = flat_bed(-20);
  const auto column = middle_beam(look(model, world, at({0, 0, -20 + kHeight_m})));
  for (int bin = 80; bin < 400; bin += 20) {
    const double range = model.acoustics().bin_centre_m(bin);
    EXPECT_NEAR(column[static_cast<std::size_t>(bin)], bed_level_db(model, world.water, -15, range), 0.05) << range;
  }
}

TEST(ForwardLooking, ArcsThatShareTheirPacketsEchoAsEachDoesAlone) {
  const ImagingModel model = quiet_forward_looking();
  const ImagingAcoustics acoustics = model.acoustics();
  const auto bins = static_cast<std::size_t>(acoustics.range_bins);
  const RayScene scene(with_box(flat_bed(-20), {12, 1, -18}, {2, 2, 3}));
  const SurfaceEchoes echoes(scene, {0, 0, -15}, acoustics, 0.05);
  std::vector<double> angles;
  for (int k = 0; k < 101; ++k) angles.push_back(-0.9 + 0.01 * k);  // fills no whole number of packets
  std::vector<double> between = angles;
  for (double& angle : between) angle += 0.005;
  const ArcRaySets sets({arc_rays(angles), arc_rays(between)});
  std::vector<RayArc> arcs;
  for (int k = 0; k < 11; ++k) {
    const double c = std::cos(0.03 * k), s = std::sin(0.03 * k);
    arcs.push_back({{c, s, 0}, Eigen::Vector3d::UnitZ(), {-s, c, 0}, 0, 0.015});
  }
  std::vector<double> together(arcs.size() * bins, 0.0);
  std::vector<EchoesByLabel> by_label(arcs.size(), EchoesByLabel(bins));
  echoes.add(arcs, sets, together, by_label);
  for (std::size_t k = 0; k < arcs.size(); ++k) {
    std::vector<double> alone(bins, 0.0);
    EchoesByLabel labels(bins);
    echoes.add(arcs[k], sets.of_arc(k), alone, &labels);
    for (std::size_t bin = 0; bin < bins; ++bin) {
      EXPECT_NEAR(together[k * bins + bin], alone[bin], 1e-5 * alone[bin]);
      EXPECT_EQ(by_label[k].strongest(bin, 0), labels.strongest(bin, 0));
    }
  }
}

TEST(ForwardLooking, TimeVariedGainMakesAFlatBedEquallyBright) {
  ImagingModel model = quiet_forward_looking();
  const auto variation = [&] {
    const auto column = middle_beam(look(model, flat_bed(-20), at({0, 0, -20 + kHeight_m})));
    const auto [low, high] = std::minmax_element(column.begin() + 100, column.end());  // from 10 m on
    return *high - *low;
  };
  EXPECT_GT(variation(), 30);
  model["time_varied_gain"] = true;
  EXPECT_LT(variation(), 1);
}

TEST(ForwardLooking, AbsorptionAppliesTwice) {
  const World world = flat_bed(-20);
  ImagingModel low = quiet_forward_looking(), high = low;
  low["frequency_hz"] = 200e3;
  high["frequency_hz"] = 900e3;
  const auto near = middle_beam(look(low, world, at({0, 0, -15})));
  const auto far = middle_beam(look(high, world, at({0, 0, -15})));
  const double more_db_m =
      high.acoustics().absorption_db_m(world.water, -15) - low.acoustics().absorption_db_m(world.water, -15);
  EXPECT_GT(more_db_m, 0.1);
  for (std::size_t bin = 100; bin < 400; bin += 50) {
    const double range = low.acoustics().bin_centre_m(static_cast<int>(bin));
    EXPECT_NEAR(near[bin] - far[bin], 2 * more_db_m * range, 2 * more_db_m * low.acoustics().bin_m()) << range;
  }
}

TEST(ForwardLooking, TheShadowOfABoxEndsWhereTheRayOverItsTopMeetsTheBed) {
  ImagingModel model = quiet_forward_looking();
  model["beam_width_rad"] = 0.3 * kDegree;  // with wider beams, side lobes receive the box's far edge from farther away
  model["columns_per_beam"] = 8;
  const double top = 1.5, front = 12, back = 13;
  const World world = with_box(flat_bed(-20), {(front + back) / 2, 0, -20 + top / 2}, {back - front, 8, top});
  const auto column = middle_beam(look(model, world, at({0, 0, -20 + kHeight_m})));
  const double begins = std::hypot(back, kHeight_m - top);
  const double ends = std::hypot(back * kHeight_m / (kHeight_m - top), kHeight_m);
  for (int bin = 0; bin < 400; ++bin) {
    const double range = model.acoustics().bin_centre_m(bin);
    const double level = column[static_cast<std::size_t>(bin)];
    if (range > begins + 0.1 && range < ends - 0.1) {
      EXPECT_LT(level, 0) << "in the shadow at " << range;
    } else if ((range > kHeight_m + 0.2 && range < begins - 0.1) || range > ends + 0.1) {
      EXPECT_GT(level, 20) << "outside the shadow at " << range;
    }
  }
}

TEST(ForwardLooking, AStrongTargetShowsInTheSideLobesOfTheArray) {
  ImagingModel model = quiet_forward_looking();
  const World world = with_box({}, {20, 0, -30}, {0.05, 0.05, 0.05});
  const auto levels = look(model, world, at({0, 0, -30}));
  const auto row = std::max_element(levels.begin(), levels.end()) - levels.begin() - 30;
  const BeamPattern across(model["beam_width_rad"], model["taper"], 1e-4);
  for (int beam = 27; beam < 34; ++beam) {
    const double off = bearing_rad(beam);
    EXPECT_NEAR(levels[static_cast<std::size_t>(row + beam)] - levels[static_cast<std::size_t>(row + 30)],
                10 * std::log10(across.power(off)), 1.0)
        << beam;
  }
}

TEST(ForwardLooking, AHeadInTheAirOrInTheGroundReceivesOnlyNoiseAndDrySurfacesReturnNoEcho) {
  ImagingModel model = quiet_forward_looking();
  model["rays_per_column"] = 200;
  const World world = with_box(flat_bed(-20), {10, 0, 3}, {2, 20, 4});  // a dry box ahead
  for (const Pose& pose : {at({0, 0, 1}), at({0, 0, -21})}) {
    for (const float level : look(model, world, pose)) ASSERT_LT(level, -290) << pose.position_m.z();
  }
  const auto beneath = middle_beam(look(model, world, at({0, 0, -0.5})));
  for (std::size_t bin = 0; bin < 193; ++bin) ASSERT_LT(beneath[bin], -290) << "nearer than the bed, 19.5 m below";
  EXPECT_GT(beneath[200], 50);
  const auto inside = with_box(flat_bed(-20), {0, 0, -10}, {4, 4, 4});
  for (const float level : look(model, inside, at({0, 0, -10}))) ASSERT_LT(level, -290);
}

TEST(ForwardLooking, APictureIsRepeatableWhateverTheThreads) {
  ImagingModel model = quiet_forward_looking();
  model["rays_per_column"] = 100;
  model["looks"] = 1;
  model["noise_level_db"] = 40;
  const World world = flat_bed(-20);
  const auto levels = [&](testing::Pings pings) {
    pings.poses = {at({0, 0, -15})};
    return testing::values_of(model, world, pings, "level_db");
  };
  const auto one = levels({});
  EXPECT_EQ(one, levels({}));
  EXPECT_EQ(one, levels({.poses = {}, .threads = 3}));
  EXPECT_NE(one, levels({.poses = {}, .first_ping = 1}));
  EXPECT_NE(one, levels({.poses = {}, .seed = 8}));
}

TEST(ForwardLooking, LabelsTellWhichSurfaceACellShows) {
  ImagingModel model = quiet_forward_looking();
  model["noise_level_db"] = 60;
  const World world = with_box(flat_bed(-20), {10, 0, -15}, {1, 1, 1});
  const auto labels = testing::values_of(model, world, {.poses = {at({0, 0, -15})}, .with_labels = true}, "labels");
  const auto label_at = [&](double range_m) {
    return labels[static_cast<std::size_t>(range_m / model.acoustics().bin_m()) * kBeams + kMiddle];
  };
  EXPECT_EQ(label_at(3), kNothing);  // only water, above the bed
  EXPECT_EQ(label_at(7), kTerrain);
  EXPECT_EQ(label_at(9.55), kTerrain + 1);  // the box's face
  EXPECT_EQ(label_at(30), kTerrain);
  model["noise_level_db"] = 250;
  const auto none = testing::values_of(model, world, {.poses = {at({0, 0, -15})}, .with_labels = true}, "labels");
  EXPECT_EQ(std::count(none.begin(), none.end(), kNothing), static_cast<std::ptrdiff_t>(none.size()));
}

TEST(ForwardLooking, RefusesParametersOutOfRange) {
  const ImagingModel good = quiet_forward_looking();
  EXPECT_NO_THROW(good.make());
  const auto refused = [&](auto change) {
    ImagingModel model = good;
    change(model);
    EXPECT_THROW(model.make(), InvalidValue);
  };
  refused([](auto& m) { m["beams"] = 0; });
  refused([](auto& m) { m["field_of_view_rad"] = 361 * kDegree; });
  refused([](auto& m) { m["frequency_hz"] = -1; });
  refused([](auto& m) { m["range_max_m"] = 0; });
  refused([](auto& m) { m["range_bins"] = 0; });
  refused([](auto& m) { m["looks"] = -1; });
  refused([](auto& m) { m["noise_level_db"] = std::nan(""); });
  refused([](auto& m) { m["beam_width_rad"] = 0; });
  refused([](auto& m) { m["vertical_width_rad"] = 4; });
  refused([](auto& m) { m["columns_per_beam"] = 0; });
  refused([](auto& m) { m["rays_per_column"] = 1; });
  refused([](auto& m) { m["taper"] = 0.6; });
  refused([](auto& m) { m["beams"] = 12.5; });
  refused([](auto& m) { m["wings"] = 2; });
  refused([](auto& m) { m.parameters.erase("beams"); });
  refused([](auto& m) { m.kind = "sonar"; });
}

}  // namespace
}  // namespace uwsim
