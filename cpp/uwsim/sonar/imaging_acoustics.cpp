#include "uwsim/sonar/imaging_acoustics.h"

#include <algorithm>
#include <cmath>

#include "uwsim/acoustics/sea_water.h"
#include "uwsim/core/check.h"

namespace uwsim {
namespace {

constexpr int kMostLooks = 16;  // a product of more uniforms might underflow
constexpr int kMostBins = 20000;
constexpr double kLoudest_db = 300;  // far beyond any transducer; keeps powers within a double

double power_of(double level_db) { return std::pow(10.0, level_db / 10); }

void require_level(double level_db, const char* name) {
  require(std::abs(level_db) <= kLoudest_db, name, level_db, "must be in [-300, 300] dB");
}

}  // namespace

void ImagingAcoustics::check() const {
  require(frequency_hz >= 1e3 && frequency_hz <= 5e6, "sonar.frequency_hz", frequency_hz, "must be in [1e3, 5e6] Hz");
  require_level(source_level_db, "sonar.source_level_db");
  require_level(noise_level_db, "sonar.noise_level_db");
  require_level(bottom_strength_db, "sonar.bottom_strength_db");
  require_level(solid_strength_db, "sonar.solid_strength_db");
  for (const double strength_db : strengths_db) {
    if (!std::isnan(strength_db)) require_level(strength_db, "sonar.strengths_db");
  }
  require(range_max_m >= 0.1 && range_max_m <= 2000, "sonar.range_max_m", range_max_m, "must be in [0.1, 2000] m");
  require(range_bins >= 1 && range_bins <= kMostBins, "sonar.range_bins", range_bins, "must be in [1, 20000]");
  require(gain_db_decade >= 0 && gain_db_decade <= 100, "sonar.gain_db_decade", gain_db_decade,
          "must be in [0, 100] dB");
  require(looks >= 0 && looks <= kMostLooks, "sonar.looks", looks, "must be in [0, 16]");
}

double ImagingAcoustics::strength(Label label) const {
  if (label < strengths_db.size() && !std::isnan(strengths_db[label])) return power_of(strengths_db[label]);
  return power_of(label == kTerrain ? bottom_strength_db : solid_strength_db);
}

double ImagingAcoustics::absorption_db_m(const Water& water, double head_z_m) const {
  return absorption_db_km(frequency_hz, water.temperature_deg_c(head_z_m), water.salinity_at_psu(head_z_m),
                          std::max(0.0, Water::depth_m(head_z_m))) /
         1000;
}

ImagingReceiver::ImagingReceiver(const ImagingAcoustics& acoustics, double absorption_db_m, const RandomStream& random)
    : acoustics_(acoustics),
      absorption_db_m_(absorption_db_m),
      random_(random),
      source_(power_of(acoustics.source_level_db)),
      noise_(power_of(acoustics.noise_level_db)) {}

double ImagingReceiver::received(double echo, std::uint64_t tick, std::uint32_t cell) const {
  const double mean = source_ * echo + noise_;
  const int looks = acoustics_.looks;
  if (looks == 0) return mean;
  double product = 1;
  for (int look = 0; look < looks; ++look) {
    product *= random_.uniform(tick, cell * static_cast<std::uint32_t>(looks) + static_cast<std::uint32_t>(look));
  }
  return mean * -std::log(product) / looks;
}

float ImagingReceiver::shown_db(double received, double range_m) const {
  double level = 10 * std::log10(received);
  if (acoustics_.time_varied_gain) {
    level += acoustics_.gain_db_decade * std::log10(range_m) + 2 * absorption_db_m_ * range_m;
  }
  return static_cast<float>(level);
}

}  // namespace uwsim
