#include "uwsim/world/tide.h"

#include <cmath>
#include <utility>

#include "uwsim/core/check.h"

namespace uwsim {

Tide::Tide(std::vector<TidalConstituent> constituents) : constituents_(std::move(constituents)) {
  for (const TidalConstituent& each : constituents_) {
    require(std::isfinite(each.speed_rad_s) && std::isfinite(each.phase_rad), "water.tide.phase_rad", each.phase_rad,
            "must be finite, as the speed must");
    bound_m_ += std::abs(each.amplitude_m);
  }
  require(bound_m_ <= 20, "water.tide.amplitude_m", bound_m_, "must add up to at most 20 m");
}

double Tide::height_m(double time_s) const {
  double sum_m = 0;
  for (const TidalConstituent& each : constituents_) {
    sum_m += each.amplitude_m * std::cos(each.speed_rad_s * time_s - each.phase_rad);
  }
  return sum_m;
}

}  // namespace uwsim
