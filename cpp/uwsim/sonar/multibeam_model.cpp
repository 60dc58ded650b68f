#include "uwsim/sonar/multibeam_model.h"

#include <array>
#include <numbers>

#include "uwsim/core/check.h"

namespace uwsim {

void MultibeamModel::check() const {
  const auto in = [](double value, double low, double high, const char* path, const char* rule) {
    require(value >= low && value <= high, path, value, rule);
  };
  in(beams, 2, 8192, "sonar.beams", "must be in [2, 8192]");
  in(field_of_view_rad, 1e-3, 2 * std::numbers::pi + 1e-9, "sonar.field_of_view_rad", "must be in [0.001, 2 pi] rad");
  in(range_max_m, 0.1, 12000, "sonar.range_max_m", "must be in [0.1, 12000] m");
  in(range_limit_m, 0.1, range_max_m, "sonar.range_limit_m", "must be in [0.1, range_max_m] m");
  in(frequency_hz, 1e3, 5e6, "sonar.frequency_hz", "must be in [1000, 5000000] Hz");
  in(ping_rate_max_hz, 0.01, 1000, "sonar.ping_rate_max_hz", "must be in [0.01, 1000] Hz");
  in(receiver_tilt_rad, 0, std::numbers::pi / 2, "sonar.receiver_tilt_rad", "must be in [0, pi/2] rad");
  in(gain_db, -100, 100, "sonar.gain_db", "must be in [-100, 100] dB");
  in(tilt_rate_rad_s, 1e-4, 100, "sonar.tilt_rate_rad_s", "must be in [0.0001, 100] rad/s");
}

const MultibeamModel& em2040(int number) {
  constexpr double kDegree = std::numbers::pi / 180;
  const auto model = [](int n, const char* name, int beams, double field_deg, double range_m, double hz, bool dual) {
    MultibeamModel made{n, name, beams, field_deg * kDegree, range_m, range_m - 0.1, hz, dual};
    made.receiver_tilt_rad = dual ? field_deg / 4 * kDegree : 0;
    return made;
  };
  static const std::array<MultibeamModel, 4> models = {{
      model(1, "EM 2040 MKII, 600 kHz, single swath", 513, 85, 95, 600e3, false),
      model(2, "EM 2040 MKII, 700 kHz, single swath", 513, 85, 55, 700e3, false),
      model(3, "EM 2040 MKII, 600 kHz, dual swath", 1025, 170, 95, 600e3, true),
      model(4, "EM 2040 MKII, 700 kHz, dual swath", 1025, 170, 55, 700e3, true),
  }};
  require(number >= 1 && number <= 4, "sonar.model", number, "must be 1, 2, 3 or 4");
  return models[static_cast<std::size_t>(number - 1)];
}

}  // namespace uwsim
