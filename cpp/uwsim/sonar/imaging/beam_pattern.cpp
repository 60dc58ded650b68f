#include "uwsim/sonar/imaging/beam_pattern.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

double sinc(double u) {
  const double x = std::numbers::pi * u;
  return std::abs(x) < 1e-9 ? 1.0 : std::sin(x) / x;
}

}  // namespace

BeamPattern::BeamPattern(double width_rad, double taper, double floor) : taper_(taper), floor_(floor) {
  require(width_rad > 0 && width_rad <= std::numbers::pi, "beam.width_rad", width_rad, "must be in (0, pi] rad");
  require(taper >= 0 && taper <= 0.5, "beam.taper", taper, "must be in [0, 0.5]");
  require(floor >= 0 && floor < 1, "beam.floor", floor, "must be in [0, 1)");
  double low = 0, high = 1;  // bracket the half-power point: H^2 <= 1/4 at u = 1
  for (int halving = 0; halving < 60; ++halving) {
    const double middle = (low + high) / 2;
    (amplitude(middle) * amplitude(middle) > 0.5 ? low : high) = middle;
  }
  lengths_per_wave_ = low / std::sin(width_rad / 2);
}

double BeamPattern::power(double off_axis_rad) const {
  const double h = amplitude_at(off_axis_rad);
  return std::max(h * h, floor_);
}

double BeamPattern::amplitude_at(double off_axis_rad) const {
  return amplitude(lengths_per_wave_ * std::sin(std::min(std::abs(off_axis_rad), std::numbers::pi / 2)));
}

double BeamPattern::amplitude(double u) const {
  return sinc(u) + taper_ / (2 * (1 - taper_)) * (sinc(u - 1) + sinc(u + 1));
}

}  // namespace uwsim
