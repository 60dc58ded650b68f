#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "acoustics/profile_of.h"
#include "uwsim/acoustics/modem/ambient_noise.h"
#include "uwsim/acoustics/modem/arrival_cells.h"
#include "uwsim/acoustics/modem/bottom_reflection.h"
#include "uwsim/acoustics/modem/boundary_loss.h"
#include "uwsim/acoustics/modem/packet_error.h"
#include "uwsim/acoustics/modem/reception.h"
#include "uwsim/core/random.h"

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

TEST(BoundaryLoss, ABottomReflectsAsInArlpy) {
  struct Case {
    FluidBottom bottom;
    double grazing_deg;
    std::complex<double> expected;
  };
  const FluidBottom clay{1.5, 1.0, 0.2}, silt{1.7, 1.05, 1.0}, sand{1.9, 1.1, 0.8}, gravel{2.0, 1.2, 0.6};
  // arlpy 1.9.3, uwa.reflection_coeff
  const Case cases[] = {
      {clay, 10, {0.193866178, -0.057470648}},    {clay, 60, {0.199993984, -0.002345372}},
      {silt, 10, {0.080506906, -0.779743165}},    {silt, 30, {0.360569263, -0.045512901}},
      {sand, 10, {-0.133411238, -0.910811437}},   {sand, 30, {0.543366748, -0.054397484}},
      {gravel, 10, {-0.381911134, -0.896921343}}, {gravel, 30, {0.839961839, -0.424392966}},
  };
  for (const auto& [bottom, grazing_deg, expected] : cases) {
    const double grazing_rad = grazing_deg * std::numbers::pi / 180;
    EXPECT_LT(std::abs(bottom_reflection(bottom, grazing_rad) - expected), 1e-8) << bottom.density_ratio << grazing_deg;
    EXPECT_NEAR(bottom_loss_db(bottom, grazing_rad), -20 * std::log10(std::abs(expected)), 1e-6);
  }
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

/// The integral over x from 0 to `end`, by the midpoint rule.
template <typename Function>
double integral(double end, Function function) {
  constexpr int kSteps = 200'000;
  double sum = 0;
  for (int k = 0; k < kSteps; ++k) sum += function((k + 0.5) * end / kSteps);
  return sum * end / kSteps;
}

TEST(PacketError, InFadingIsTheMeanOverExponentiallyDistributedSignals) {
  for (const Modulation each : {Modulation::kPsk, Modulation::kFsk}) {
    for (const double mean : {0.5, 5.0, 50.0}) {
      const double averaged = integral(40, [&](double x) { return std::exp(-x) * bit_error(each, false, mean * x); });
      EXPECT_NEAR(bit_error(each, true, mean), averaged, 1e-6) << mean;
    }
  }
}

TEST(PacketError, OfTonesIsTheChanceThatNoiseAloneIsStronger) {
  for (const double gamma : {0.5, 4.0, 9.0}) {
    const double amplitude =
        std::sqrt(2 * gamma);  // of the tone in noise of unit variance: Rice; of the other: Rayleigh
    const double wrong = integral(amplitude + 12, [&](double r) {
      return r * std::exp(-(r * r + 2 * gamma) / 2) * std::cyl_bessel_i(0, amplitude * r) * std::exp(-r * r / 2);
    });
    EXPECT_NEAR(bit_error(Modulation::kFsk, false, gamma), wrong, 1e-8) << gamma;
  }
}

ModemWater even_water() {
  return {SoundSpeedProfile::even(1500), AbsorptionColumn([](double) { return 5.0; }, 100), {}, 0, 40};
}

/// Two ends at a depth of 20 m in 50 m of water, at rest.
Reception heard(const ModemSpec& modem, const ModemWater& water, double range_m, bool with_bounces) {
  std::vector<HeardPath> paths;
  const SoundLosses losses{modem.frequency_hz, water.bottom, water.surface_rms_m, &water.absorption};
  const ArrivalLimits limits{.most_bounces = with_bounces ? 100 : 0};
  for (const Arrival& one : arrivals(water.profile, {20, 20, range_m, 50}, losses, limits)) {
    paths.push_back({one.time_s, modem.source_level_db + one.level_db, 0});
  }
  return reception(modem, water, paths);
}

TEST(Reception, OfOnePathIsThePassiveSonarEquation) {
  const ModemSpec modem;
  const Reception at = heard(modem, even_water(), 1000, false);
  EXPECT_NEAR(at.delay_s, 1000.0 / 1500, 1e-9);
  EXPECT_NEAR(at.signal_db, modem.source_level_db - 60 - 5, 1e-3);
  EXPECT_NEAR(at.signal_db, modem.source_level_db - spherical_loss_db(even_water(), 1000, 20), 1e-3);
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

TEST(Reception, AnEchoBeyondTheGuardTimeDisturbsTheMoreTheLaterItIs) {
  ModemSpec modem;
  modem.multipath_window_s = 0.01;
  modem.symbol_s = 0.004;
  const auto ratio_db = [&](double late_s) {
    return reception(modem, even_water(), std::vector<HeardPath>{{1, 150, 0}, {1 + late_s, 150, 0}}).snr_db();
  };
  EXPECT_NEAR(reception(modem, even_water(), std::vector<HeardPath>{{1, 150, 0}, {1.0099, 150, 0}}).signal_db,
              150 + 10 * std::log10(2), 1e-9);
  // Half a symbol beyond the guard time a quarter of the echo's power is signal: (1 + 1/4) / (3/4); later it is 1 / 1.
  EXPECT_NEAR(ratio_db(0.012), 10 * std::log10(5.0 / 3), 1e-3);
  EXPECT_NEAR(ratio_db(0.015), 0, 1e-3);
  modem.symbol_s = 0;
  EXPECT_NEAR(ratio_db(0.0101), 0, 1e-3);
}

TEST(Reception, EachArrivalHasItsOwnDopplerAndAWeakForerunnerIsNotTheFirst) {
  ModemSpec modem;
  modem.speed_max_m_s = 5;
  const Reception at =
      reception(modem, even_water(), std::vector<HeardPath>{{0.99, 120, 0}, {1, 145, 6}, {1.001, 150, 3}});
  EXPECT_EQ(at.closing_m_s, 3) << "of the strongest";
  EXPECT_EQ(at.delay_s, 1) << "of the first within 20 dB";
  EXPECT_NEAR(at.spread_s, 0.001, 1e-12);
  EXPECT_NEAR(at.snr_db(), 5, 1e-3) << "the faster one is only noise";
}

double apart_s(const Arrival& a, const Arrival& b) {
  const bool same = a.surface_bounces == b.surface_bounces && a.bottom_bounces == b.bottom_bounces &&
                    a.turns == b.turns && (a.launch_dip_rad > 0) == (b.launch_dip_rad > 0);
  return same ? std::abs(a.time_s - b.time_s) : 1;
}

TEST(ArrivalCells, TheirTimesAndLevelsAreThoseOfTheTrueEnds) {
  const auto profile = profile_of({0, 10, 20, 45}, {1480, 1478, 1450, 1447});
  const SoundLosses losses{25e3, {1.7, 1.05, 1}};
  const RandomStream stream(5, "ends");
  ArrivalCells cells(16);
  int compared = 0;
  double late = 0, louder_db = 0;
  for (std::uint64_t k = 0; k < 40; ++k) {
    const RayEnds ends{1 + 38 * stream.uniform(k), 1 + 38 * stream.uniform(k, 1), 30 + 400 * stream.uniform(k, 2),
                       42.3};
    const auto exact = arrivals(profile, ends, losses, {.within_db = 31});
    for (const Arrival& near : cells.at(profile, ends, losses)) {
      const auto other = std::min_element(exact.begin(), exact.end(), [&](const Arrival& a, const Arrival& b) {
        return apart_s(near, a) < apart_s(near, b);
      });
      // Rays that turn may begin or end at a caustic within the cell
      if (other == exact.end() || near.turns > 0) continue;
      EXPECT_NEAR(near.time_s, other->time_s, near.time_s / 8192);  // near a caustic
      late += std::abs(near.time_s - other->time_s) / near.time_s;
      louder_db += std::abs(near.level_db - other->level_db);
      ++compared;
    }
  }
  EXPECT_GT(compared, 200);
  EXPECT_LT(late / compared, 5e-6);
  EXPECT_LT(louder_db / compared, 0.1);
}

TEST(ArrivalCells, WhatTheyContainDoesNotDependOnTheOrderOfCalls) {
  const auto profile = profile_of({0, 45}, {1480, 1447});
  const SoundLosses losses{25e3, {1.7, 1.05, 1}};
  const RandomStream stream(6, "ends");
  ArrivalCells one(1), many(64);
  const auto ends = [&](std::uint64_t k) {
    return RayEnds{1 + 38 * stream.uniform(k), 12, 30 + 90 * stream.uniform(k, 1), 42};
  };
  for (std::uint64_t k = 0; k < 60; ++k) many.at(profile, ends(59 - k), losses);
  for (std::uint64_t k = 0; k < 60; ++k) {
    const auto a = one.at(profile, ends(k), losses), b = many.at(profile, ends(k), losses);
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t j = 0; j < a.size(); ++j) {
      EXPECT_EQ(a[j].time_s, b[j].time_s);
      EXPECT_EQ(a[j].level_db, b[j].level_db);
    }
  }
}

TEST(Reception, WithoutAPathEverythingIsLost) {
  EXPECT_EQ(packet_loss(ModemSpec{}, reception(ModemSpec{}, even_water(), {}), -300, 32), 1);
}

}  // namespace
}  // namespace uwsim
