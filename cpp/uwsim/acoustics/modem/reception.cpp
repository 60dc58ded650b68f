#include "uwsim/acoustics/modem/reception.h"

#include <algorithm>
#include <cmath>

namespace uwsim {
namespace {

// Arrivals that are weaker than the strongest by more than this are ignored in the spread
constexpr double kAudible_db = 20;

double power(double level_db) { return std::pow(10, 0.1 * level_db); }
double level_db(double power) { return 10 * std::log10(std::max(power, 1e-30)); }

}  // namespace

double path_loss_db(const ModemSpec& modem, const ModemWater& water, const Eigenray& ray, double from_depth_m,
                    double to_depth_m) {
  double loss = 20 * std::log10(std::max(ray.length_m, 1.0)) +
                water.absorption.mean_db_m(from_depth_m, to_depth_m) * ray.length_m;
  if (ray.surface_bounces > 0) {
    loss += ray.surface_bounces *
            surface_loss_db(modem.frequency_hz, water.profile.at(0), water.surface_rms_m, ray.surface_grazing_rad);
  }
  if (ray.bottom_bounces > 0) loss += ray.bottom_bounces * bottom_loss_db(water.bottom, ray.bottom_grazing_rad);
  return loss;
}

Reception reception(const ModemSpec& modem, const ModemWater& water, std::span<const HeardPath> paths) {
  Reception heard;
  const double noise = power(water.noise_db_hz) + power(modem.receiver_noise_db_hz);
  double signal = 0, late = 0, strongest = -1e9;
  for (const HeardPath& path : paths) {
    if (!heard.reached || path.ray.time_s < heard.delay_s) heard.delay_s = path.ray.time_s;
    heard.reached = true;
    strongest = std::max(strongest, path.level_db);
  }
  for (const HeardPath& path : paths) {
    const double after_s = path.ray.time_s - heard.delay_s;
    (after_s <= modem.multipath_window_s ? signal : late) += power(path.level_db);
    if (path.level_db > strongest - kAudible_db) heard.spread_s = std::max(heard.spread_s, after_s);
  }
  heard.signal_db = level_db(signal);
  heard.noise_db = level_db(noise * modem.bandwidth_hz + late);
  return heard;
}

double packet_loss(const ModemSpec& modem, const Reception& heard, double interference_db, std::uint64_t bytes) {
  if (!heard.reached) return 1;
  const double ratio = power(heard.signal_db) / (power(heard.noise_db) + power(interference_db));
  const double gamma = ratio * modem.bandwidth_hz / modem.bit_rate_bit_s * power(modem.coding_gain_db);
  return packet_error(bit_error(modem.modulation, modem.fading, gamma),
                      8 * static_cast<double>(bytes + modem.header_bytes));
}

}  // namespace uwsim
