#include <gtest/gtest.h>

#include <cmath>

#include "uwsim/acoustics/modem/ambient_noise.h"
#include "uwsim/acoustics/modem/boundary_loss.h"
#include "uwsim/acoustics/modem/packet_error.h"
#include "uwsim/acoustics/modem/reception.h"

namespace uwsim {
namespace {

TEST(BoundaryLoss, AFlatSurfaceLosesNothingAndARoughOneMoreAtSteeperAngles) {
  EXPECT_EQ(surface_loss_db(25e3, 1500, 0, 0.3), 0);
  const double shallow = surface_loss_db(25e3, 1500, 0.01, 0.1), steep = surface_loss_db(25e3, 1500, 0.01, 0.2);
  EXPECT_NEAR(steep / shallow, std::pow(std::sin(0.2) / std::sin(0.1), 2), 1e-9);
}

TEST(BoundaryLoss, ALosslessFastBottomReflectsAllBelowTheCriticalAngle) {
  const FluidBottom sand{1.9, 1.1, 0};
  const double critical = std::acos(1 / 1.1);
  EXPECT_NEAR(bottom_loss_db(sand, 0.99 * critical), 0, 1e-9);
  EXPECT_GT(bottom_loss_db(sand, 1.2 * critical), 3);
  const double normal = (1.9 * 1.1 - 1) / (1.9 * 1.1 + 1);
  EXPECT_NEAR(bottom_loss_db(sand, std::acos(0.0)), -20 * std::log10(normal), 1e-9) << "ratio of impedances";
  EXPECT_GT(bottom_loss_db({1.9, 1.1, 0.8}, 0.5 * critical), 0.1) << "attenuation costs below it, too";
}

TEST(AmbientNoise, WindRaisesItAndThermalNoiseRulesAtTheTop) {
  // At 1 kHz without wind: turbulence 17, shipping 40 - 60 log 1.03, wind 50 - 40 log 1.4 dB.
  const double power = std::pow(10, 1.7) + 1e4 / std::pow(1.03, 6) + 1e5 / std::pow(1.4, 4) + std::pow(10, -1.5);
  EXPECT_NEAR(ambient_noise_db_hz(1e3, {0, 0.5}), 10 * std::log10(power), 1e-9);
  EXPECT_GT(ambient_noise_db_hz(10e3, {10, 0.5}), ambient_noise_db_hz(10e3, {1, 0.5}) + 10);
  EXPECT_NEAR(ambient_noise_db_hz(500e3, {0, 0}), -15 + 20 * std::log10(500), 0.5);
}

TEST(PacketError, FollowsTheTextbooksCurves) {
  EXPECT_NEAR(bit_error(Modulation::kFsk, false, 2 * std::log(50)), 0.01, 1e-12);
  EXPECT_NEAR(bit_error(Modulation::kFsk, true, 98), 0.01, 1e-12);
  EXPECT_NEAR(bit_error(Modulation::kPsk, false, std::pow(10, 0.96)), 1e-5, 2e-6) << "9.6 dB for 1e-5";
  EXPECT_NEAR(bit_error(Modulation::kPsk, true, 1e4), 0.25e-4, 1e-8);
  EXPECT_NEAR(packet_error(1e-3, 1000), 1 - std::pow(0.999, 1000), 1e-12);
}

ModemWater even_water() {
  return {SoundSpeedProfile::even(1500), AbsorptionColumn([](double) { return 5.0; }, 100), {}, 0, 40};
}

Reception heard(const ModemSpec& modem, const ModemWater& water, double range_m, bool with_bounces) {
  std::vector<HeardPath> paths;
  for (const Eigenray& ray : eigenrays(water.profile, {20, 20, range_m, 50}, with_bounces)) {
    paths.push_back({ray, modem.source_level_db - path_loss_db(modem, water, ray, 20, 20)});
  }
  return reception(modem, water, paths);
}

TEST(Reception, OfOnePathIsThePassiveSonarEquation) {
  const ModemSpec modem;
  const Reception at = heard(modem, even_water(), 1000, false);
  EXPECT_NEAR(at.delay_s, 1000.0 / 1500, 1e-9);
  EXPECT_NEAR(at.signal_db, modem.source_level_db - 60 - 5, 1e-3);
  EXPECT_NEAR(at.noise_db, 40 + 10 * std::log10(modem.bandwidth_hz), 1e-2);
}

TEST(Reception, EchoesHelpWithinTheWindowAndDisturbBeyond) {
  ModemSpec modem;
  modem.multipath_window_s = 1;
  const Reception wide = heard(modem, even_water(), 200, true), alone = heard(modem, even_water(), 200, false);
  EXPECT_GT(wide.signal_db, alone.signal_db + 1);
  modem.multipath_window_s = 0;
  const Reception narrow = heard(modem, even_water(), 200, true);
  EXPECT_NEAR(narrow.signal_db, alone.signal_db, 1e-6);
  EXPECT_GT(narrow.noise_db, alone.noise_db + 20);
  EXPECT_GT(packet_loss(modem, narrow, -300, 32), packet_loss(modem, alone, -300, 32));
}

TEST(Reception, WithoutAPathEverythingIsLost) {
  EXPECT_EQ(packet_loss(ModemSpec{}, reception(ModemSpec{}, even_water(), {}), -300, 32), 1);
}

}  // namespace
}  // namespace uwsim
