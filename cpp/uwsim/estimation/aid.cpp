#include "uwsim/estimation/aid.h"

namespace uwsim {

void Aid::doubt(FilterState& state, double residual) const {
  for (int k = seen(); k < seen() + 3; ++k) state.covariance(k, k) += residual * residual;
}

bool Aid::correct(FilterState& state, double residual, const ErrorVector& h, double variance,
                  double constant_variance) const {
  ErrorMatrix& p = state.covariance;
  AidCounts& counts = state.counts[static_cast<std::size_t>(index)];
  ErrorVector seen_by = p * h;
  double own = h.dot(seen_by);
  if (residual * residual > kGate * kGate * (own + variance + constant_variance)) {
    ++counts.rejected;
    if (counts.in_a_row + 1 < kReadingsBeforeDoubt) return false;
    doubt(state, residual);
    ++state.doubts;
    state.doubted_up_m = residual * h[kPosition + 2];
    seen_by = p * h;
    own = h.dot(seen_by);
  } else {
    ++counts.accepted;
  }
  if (constant_variance > 0) {
    if (own <= constant_variance) return true;  // known as well as the reading is
    variance += own * constant_variance / (own - constant_variance);
  }
  const ErrorVector gain = seen_by / (own + variance);
  state.add(gain * residual);
  // The Joseph form, (I - K h) P (I - K h)^T + K R K^T, computed as two rank-one updates.
  p.noalias() -= gain * seen_by.transpose();
  const ErrorVector left = p * h;
  p.noalias() += (variance * gain - left) * gain.transpose();
  p = (0.5 * (p + p.transpose())).eval();
  return true;
}

}  // namespace uwsim
