#include "uwsim/acoustics/modem/reception.h"

#include <algorithm>
#include <cmath>

namespace uwsim {
namespace {

// Arrivals that are weaker than the strongest by more than this are ignored: each has less than 1 % of its power
constexpr double kAudible_db = 20;

double power(double level_db) { return std::pow(10, 0.1 * level_db); }
double level_db(double power) { return 10 * std::log10(std::max(power, 1e-30)); }

}  // namespace

double spherical_loss_db(const ModemWater& water, double length_m, double depth_m) {
  return 20 * std::log10(std::max(length_m, 1.0)) + water.absorption.at_db_m(depth_m) * length_m;
}

double symbol_share(const ModemSpec& modem, double delay_s) {
  const double late_s = delay_s - modem.multipath_window_s;
  if (late_s <= 0) return 1;
  const double overlap = late_s < modem.symbol_s ? 1 - late_s / modem.symbol_s : 0;
  return overlap * overlap;
}

Reception reception(const ModemSpec& modem, const ModemWater& water, std::span<const HeardPath> paths) {
  Reception heard;
  const double noise = power(water.noise_db_hz) + power(modem.receiver_noise_db_hz);
  double signal = 0, interference = 0, strongest = -1e9, last_s = -1e9;
  for (const HeardPath& path : paths) {
    if (path.level_db <= strongest) continue;
    strongest = path.level_db;
    heard.closing_m_s = path.closing_m_s;
  }
  for (const HeardPath& path : paths) {
    if (path.level_db < strongest - kAudible_db) continue;
    if (!heard.reached || path.time_s < heard.delay_s) heard.delay_s = path.time_s;
    last_s = std::max(last_s, path.time_s);
    heard.reached = true;
  }
  for (const HeardPath& path : paths) {
    if (path.level_db < strongest - kAudible_db) continue;
    const bool tracked = std::abs(path.closing_m_s) <= modem.speed_max_m_s;
    const double share = tracked ? symbol_share(modem, path.time_s - heard.delay_s) : 0;
    signal += share * power(path.level_db);
    interference += (1 - share) * power(path.level_db);
  }
  if (heard.reached) heard.spread_s = last_s - heard.delay_s;
  heard.signal_db = level_db(signal);
  heard.noise_db = level_db(noise * modem.bandwidth_hz + interference);
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
