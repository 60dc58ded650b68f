#include "uwsim/sonar/water_sound.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "uwsim/acoustics/sea_water.h"

namespace uwsim {
namespace {

/// The second derivative of Mackenzie's speed by temperature is at most 0.106 (m/s)/K^2: linear interpolation over 2 K
/// is within 0.05 m/s.
constexpr double kPiece_k = 1.9;

std::vector<double> kinks_m(const Water& water) {
  if (!water.profile) return {0, water.bottom_depth_m};
  std::vector<double> depths;
  for (const WaterLevel& level : water.profile->levels()) depths.push_back(level.depth_m);
  return depths;
}

}  // namespace

double sound_speed_m_s(const Water& water, double z_world_m) {
  const double given = water.given_sound_speed_m_s(z_world_m);
  if (given > 0) return given;
  return sound_speed_m_s(water.temperature_deg_c(z_world_m), water.salinity_at_psu(z_world_m),
                         std::max(0.0, Water::depth_m(z_world_m)));
}

SoundSpeedProfile sound_speed_profile(const Water& water) {
  const std::vector<double> kinks = kinks_m(water);
  const bool given = water.given_sound_speed_m_s(0) > 0;
  std::vector<double> depths = {kinks.front()};
  for (std::size_t k = 1; k < kinks.size(); ++k) {
    const double warmer = water.temperature_deg_c(-kinks[k]) - water.temperature_deg_c(-kinks[k - 1]);
    const int pieces = given ? 1 : std::max(1, static_cast<int>(std::ceil(std::abs(warmer) / kPiece_k)));
    for (int piece = 1; piece <= pieces; ++piece) {
      depths.push_back(kinks[k - 1] + (kinks[k] - kinks[k - 1]) * piece / pieces);
    }
  }
  std::vector<double> speeds;
  for (const double depth : depths) speeds.push_back(sound_speed_m_s(water, -depth));
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
