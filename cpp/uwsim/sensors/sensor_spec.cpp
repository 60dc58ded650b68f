#include "uwsim/sensors/sensor_spec.h"

#include <cmath>

#include "uwsim/core/check.h"

namespace uwsim {

void NoiseSpec::check(const std::string& path) const {
  const std::pair<const char*, double> magnitudes[] = {
      {".std", std},
      {".density", density},
      {".turn_on_std", turn_on_std},
      {".bias_std", bias_std},
      {".bias_time_s", bias_time_s},
      {".walk", walk},
      {".instability", instability},
      {".quantum", quantum},
  };
  for (const auto& [name, value] : magnitudes) {
    require(std::isfinite(value) && value >= 0, path + name, value, "must be finite and not negative");
  }
  require(bias_std == 0 || bias_time_s > 0, path + ".bias_time_s", bias_time_s, "must be positive if bias_std is");
  require(limit_low < limit_high, path + ".limit_low", limit_low, "must be below limit_high");
}

}  // namespace uwsim
