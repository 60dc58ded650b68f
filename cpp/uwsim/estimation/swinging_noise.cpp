#include "uwsim/estimation/swinging_noise.h"

#include <cmath>

namespace uwsim {
namespace {

constexpr double kDamping = 0.5;  // assumed: a band of about an octave to either side

/// The matrix that advances a and b over dt.
Eigen::Matrix2d kept_after(double frequency_rad_s, double dt_s) {
  const double decay = kDamping * frequency_rad_s;
  const double swing = frequency_rad_s * std::sqrt(1 - kDamping * kDamping);
  Eigen::Matrix2d off;
  off << decay, frequency_rad_s, -frequency_rad_s, -decay;
  return std::exp(-decay * dt_s) *
         (std::cos(swing * dt_s) * Eigen::Matrix2d::Identity() + std::sin(swing * dt_s) / swing * off);
}

}  // namespace

void swing(FilterState& state, int first, double frequency_rad_s, double variance, double dt_s) {
  ErrorMatrix& p = state.covariance;
  auto both = state.aid_bias.segment<2>(first - kAidBias);
  const Eigen::Matrix2d kept = kept_after(frequency_rad_s, dt_s);
  both = (kept * both).eval();
  p.middleRows<2>(first) = (kept * p.middleRows<2>(first)).eval();
  p.middleCols<2>(first) = (p.middleCols<2>(first) * kept.transpose()).eval();
  p.block<2, 2>(first, first) += variance * (Eigen::Matrix2d::Identity() - kept * kept.transpose());
}

}  // namespace uwsim
