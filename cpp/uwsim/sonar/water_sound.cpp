#include "uwsim/sonar/water_sound.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "uwsim/acoustics/absorption.h"

namespace uwsim {
namespace {

constexpr double kDeepest_m = 12000;  // deeper than any ocean

/// An interval in which the speed of sound is assumed linear is halved until the speed at its midpoint is this
/// accurate, or until the interval is this short.
constexpr double kWithin_m_s = 0.05, kShortest_m = 0.01;
/// Initial interval sizes, which suffice in most water: the second derivative is at most 0.116 (m/s)/K^2 with respect
/// to temperature and 5e-7 (m/s)/m^2 with respect to depth; with respect to salinity, it grows with S^1.5.
constexpr double kPiece_k = 1.8, kPiece_psu = 5, kPiece_m = 800;

/// Depths at which the slope of temperature or salinity changes.
std::vector<double> kinks_m(const Water& water) {
  std::vector<double> depths = {0, water.bottom_depth_m};
  if (water.profile) {
    depths.clear();
    for (const WaterLevel& level : water.profile->levels()) depths.push_back(level.depth_m);
    if (water.gives_sound_speed()) return depths;
    if (depths.front() > 0) depths.insert(depths.begin(), 0);
  }
  if (depths.back() < kDeepest_m) depths.push_back(kDeepest_m);
  return depths;
}

int pieces_to_begin_with(const Water& water, double upper_m, double lower_m) {
  if (water.gives_sound_speed()) return 1;
  const double kelvin = water.temperature_deg_c(-lower_m) - water.temperature_deg_c(-upper_m);
  const double psu = water.salinity_at_psu(-lower_m) - water.salinity_at_psu(-upper_m);
  return std::max(1, static_cast<int>(std::ceil(std::max(
                         {std::abs(kelvin) / kPiece_k, std::abs(psu) / kPiece_psu, (lower_m - upper_m) / kPiece_m}))));
}

/// Adds levels from `upper_m` down to `lower_m` such that the speed of sound is nearly linear between them.
void add_levels(const Water& water, double upper_m, double lower_m, std::vector<double>& depths_m) {
  const double middle_m = 0.5 * (upper_m + lower_m);
  const double chord_m_s = 0.5 * (water.sound_speed_m_s(-upper_m) + water.sound_speed_m_s(-lower_m));
  if (lower_m - upper_m > kShortest_m && std::abs(chord_m_s - water.sound_speed_m_s(-middle_m)) > kWithin_m_s) {
    add_levels(water, upper_m, middle_m, depths_m);
    add_levels(water, middle_m, lower_m, depths_m);
  } else {
    depths_m.push_back(lower_m);
  }
}

}  // namespace

SoundSpeedProfile sound_speed_profile(const Water& water) {
  const std::vector<double> kinks = kinks_m(water);
  std::vector<double> depths = {kinks.front()};
  for (std::size_t k = 1; k < kinks.size(); ++k) {
    const double upper = kinks[k - 1], lower = kinks[k];
    const int pieces = pieces_to_begin_with(water, upper, lower);
    for (int piece = 1; piece < pieces; ++piece) {
      const double depth = upper + (lower - upper) * piece / pieces;
      // Guards against rounding
      if (depth > depths.back() && depth < lower) add_levels(water, depths.back(), depth, depths);
    }
    add_levels(water, depths.back(), lower, depths);
  }
  std::vector<double> speeds;
  for (const double depth : depths) speeds.push_back(water.sound_speed_m_s(-depth));
  return SoundSpeedProfile(depths, speeds);
}

AbsorptionColumn absorption_column(const Water& water, double frequency_hz, double acidity_ph, double bottom_m) {
  const auto at = [&](double depth_m) {
    return absorption_db_km(frequency_hz, water.temperature_deg_c(-depth_m), water.salinity_at_psu(-depth_m), depth_m,
                            acidity_ph);
  };
  return AbsorptionColumn(at, bottom_m);
}

}  // namespace uwsim
