#include "uwsim/acoustics/seabed.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

double strength_db(const char* name, double frequency_hz, double grazing_deg) {
  return 10 * std::log10(SeabedBackscatter(seabed(name), frequency_hz, 1528)(grazing_deg * kDegree));
}

/// Rows of TR 9407, table 3 (1528 m/s, printed to 0.1 dB), at 1, 5, 10, 20, 60, 80, 88 and 90 degrees, as transcribed
/// by the tests of uacpy.
TEST(Seabed, ReproducesThePublishedTable) {
  constexpr std::array kGrazing_deg = {1., 5., 10., 20., 60., 80., 88., 90.};
  struct Row {
    const char* name;
    double frequency_hz;
    std::array<double, 8> strength_db;
  };
  const std::array rows = {Row{"rock", 30e3, {-44.0, -28.4, -21.7, -15.4, -9.1, -7.3, -6.6, -6.6}},
                           Row{"cobble", 30e3, {-48.5, -32.6, -25.7, -19.3, -13.1, -9.2, -7.9, -7.8}},
                           Row{"sandy_gravel", 30e3, {-50.3, -35.1, -28.1, -22.1, -16.5, -9.9, -8.0, -7.8}},
                           Row{"coarse_sand", 30e3, {-47.1, -37.9, -31.5, -25.1, -18.8, -8.9, -4.6, -4.4}},
                           Row{"medium_sand", 30e3, {-51.4, -42.1, -35.4, -28.3, -21.2, -10.8, -3.4, -3.1}},
                           Row{"medium_sand", 100e3, {-50.0, -36.6, -29.8, -24.2, -19.5, -12.2, -9.8, -9.7}},
                           Row{"very_fine_sand", 30e3, {-59.7, -44.6, -35.2, -27.1, -23.7, -20.2, -5.9, -3.8}},
                           Row{"sandy_mud", 30e3, {-58.2, -41.3, -35.7, -31.8, -27.4, -26.3, -13.1, -3.6}}};
  for (const Row& row : rows) {
    for (std::size_t k = 0; k < kGrazing_deg.size(); ++k) {
      EXPECT_NEAR(strength_db(row.name, row.frequency_hz, kGrazing_deg[k]), row.strength_db[k], 0.1)
          << row.name << " at " << kGrazing_deg[k] << " degrees, " << row.frequency_hz << " Hz";
    }
  }
}

TEST(Seabed, RefusesWhatTheModelIsNotValidFor) {
  EXPECT_THROW(seabed("granite"), InvalidValue);
  EXPECT_THROW(SeabedBackscatter(seabed("rock"), 200e3, 1500), InvalidValue);
  EXPECT_THROW(SeabedBackscatter(seabed("rock"), 50e3, 1700), InvalidValue);
}

}  // namespace
}  // namespace uwsim
