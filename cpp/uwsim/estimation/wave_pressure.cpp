#include "uwsim/estimation/wave_pressure.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "uwsim/estimation/swinging_noise.h"

namespace uwsim {
namespace {

// Assumed, both: the middle of the periods of waves that reach a vehicle near the surface, and two such periods.
constexpr double kFrequency_rad_s = 2 * std::numbers::pi / 5;
constexpr double kMemory_s = 10;

}  // namespace

void WavePressure::age(FilterState& state, int first, double& own_variance, double dt_s) const {
  const double head_m = state.aid_bias[first + 1 - kAidBias];
  const double seen = head_m * head_m + state.covariance(first + 1, first + 1);
  own_variance -= std::expm1(-dt_s / kMemory_s) * (seen - own_variance);
  own_variance = std::max(own_variance, least_std_m_ * least_std_m_);
  swing(state, first, kFrequency_rad_s, own_variance, dt_s);
}

}  // namespace uwsim
