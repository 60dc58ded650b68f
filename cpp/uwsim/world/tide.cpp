#include "uwsim/world/tide.h"

#include <cmath>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

std::vector<Harmonic> harmonics(const std::vector<TidalConstituent>& constituents) {
  std::vector<Harmonic> all;
  for (const TidalConstituent& each : constituents) {
    require(std::isfinite(each.speed_rad_s) && std::isfinite(each.phase_rad), "water.tide.phase_rad", each.phase_rad,
            "must be finite, as the speed must");
    all.push_back({each.speed_rad_s,
                   {each.amplitude_m * std::cos(each.phase_rad), 0},
                   {each.amplitude_m * std::sin(each.phase_rad), 0}});
  }
  return all;
}

}  // namespace

Tide::Tide(const std::vector<TidalConstituent>& constituents) : heights_(harmonics(constituents)) {
  require(bound_m() <= 20, "water.tide.amplitude_m", bound_m(), "must add up to at most 20 m");
}

}  // namespace uwsim
