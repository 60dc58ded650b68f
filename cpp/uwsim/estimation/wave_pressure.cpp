#include "uwsim/estimation/wave_pressure.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace uwsim {
namespace {

// Assumed, all three: the middle of the periods of waves that reach a vehicle near the surface, a band of about an
// octave to either side, and two such periods.
constexpr double kFrequency_rad_s = 2 * std::numbers::pi / 5;
constexpr double kDamping = 0.5;
constexpr double kMemory_s = 10;

/// The matrix that advances a and b over dt.
Eigen::Matrix2d kept_after(double dt_s) {
  const double decay = kDamping * kFrequency_rad_s;
  const double swing = kFrequency_rad_s * std::sqrt(1 - kDamping * kDamping);
  Eigen::Matrix2d off;
  off << decay, kFrequency_rad_s, -kFrequency_rad_s, -decay;
  return std::exp(-decay * dt_s) *
         (std::cos(swing * dt_s) * Eigen::Matrix2d::Identity() + std::sin(swing * dt_s) / swing * off);
}

}  // namespace

void WavePressure::age(FilterState& state, int first, double& own_variance, double dt_s) const {
  ErrorMatrix& p = state.covariance;
  auto heads = state.aid_bias.segment<kErrors>(first - kAidBias);
  const double seen = heads[1] * heads[1] + p(first + 1, first + 1);
  own_variance -= std::expm1(-dt_s / kMemory_s) * (seen - own_variance);
  own_variance = std::max(own_variance, least_std_m_ * least_std_m_);
  const Eigen::Matrix2d kept = kept_after(dt_s);
  heads = (kept * heads).eval();
  p.middleRows<kErrors>(first) = (kept * p.middleRows<kErrors>(first)).eval();
  p.middleCols<kErrors>(first) = (p.middleCols<kErrors>(first) * kept.transpose()).eval();
  p.block<kErrors, kErrors>(first, first) += own_variance * (Eigen::Matrix2d::Identity() - kept * kept.transpose());
}

}  // namespace uwsim
