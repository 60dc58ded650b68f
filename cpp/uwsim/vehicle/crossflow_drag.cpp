#include "uwsim/vehicle/crossflow_drag.h"

#include <algorithm>
#include <cmath>

namespace uwsim {

CrossflowDrag::CrossflowDrag(double across, double turning, double length_m)
    : across_(across), half_length_m_(length_m / 2) {
  if (across > 0) half_length_m_ = std::min(half_length_m_, std::cbrt(4 * turning / across));
}

double CrossflowDrag::turning_drag() const { return across_ * half_length_m_ * half_length_m_ * half_length_m_ / 4; }

/// The integrals of (v + x w) |v + x w| and x (v + x w) |v + x w| over -h < x < h, divided by 2 h, in closed form.
/// There are two cases: all strips move in the same direction, or the hull turns about a point x0 within its length.
CrossflowDrag::Load CrossflowDrag::load(double across_m_s, double turn_rad_s) const {
  const double v = across_m_s, w = turn_rad_s, h = half_length_m_;
  if (std::abs(v) >= std::abs(w) * h) {
    return {-across_ * std::copysign(v * v + w * w * h * h / 3, v), -across_ * 2 / 3 * h * h * std::abs(v) * w};
  }
  const double x0 = -v / w, ww = w * std::abs(w);
  const double square = x0 * x0;
  return {across_ * ww * x0 * (h + square / (3 * h)),
          -across_ * ww * (h * h * h / 4 + h * square / 2 - square * square / (12 * h))};
}

}  // namespace uwsim
